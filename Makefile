# Two commands do everything; both first install what is missing (scripts/setup.sh).

# What `make run` simulates: full, less, sparse, bare or all.
COVERAGE = sparse
# What `make test` leaves out, where it cannot be had: blender, bpy, mitsuba, readers, window.
WITHOUT =

.PHONY: help run test lint setup bench intervals chart scale packings tolerances budgets facets stress clean

help: ## list the targets
	@sed -n 's/^\([a-z]*\):.*## /  make \1\t/p' Makefile

run: setup ## simulate a soil, from Blender to its emissivity curve
	cargo run --release -- pipeline --coverage $(COVERAGE)

setup: ## install what `make run` needs
	@sh scripts/setup.sh run

test: ## lint, and run every test, in Blender and in Python's bpy
	@sh scripts/setup.sh test "$(WITHOUT)"
	@$(MAKE) --no-print-directory lint
	SOILSIG_TEST_ALL=1 \
	SOILSIG_TEST_BLENDER=$(if $(filter blender,$(WITHOUT)),none,$$(command -v blender)) \
	SOILSIG_TEST_BPY=$(if $(filter bpy,$(WITHOUT)),none,$(CURDIR)/.venv/bin/python) \
	SOILSIG_TEST_WINDOW=$(if $(filter window,$(WITHOUT)),none,$$(command -v Xvfb)) \
	SOILSIG_TEST_MITSUBA=$(if $(filter mitsuba,$(WITHOUT)),none,$(CURDIR)/.tools/mitsuba/bin/python) \
	SOILSIG_TEST_READERS=$(if $(filter readers,$(WITHOUT)),none,$(CURDIR)/.tools/readers/bin/python) \
	SOILSIG_TEST_LIBRARY=$${SOILSIG_TEST_LIBRARY:-none} \
	INSTA_UPDATE=no cargo test --release
	@$(if $(WITHOUT),echo 'LEFT OUT: the tests that need $(WITHOUT)')

lint:
	cargo fmt --check
	cargo clippy --release --all-targets -- --deny warnings
	.tools/bin/ruff check
	.tools/bin/ruff format --check

bench: setup ## time the pipeline, and the tracer beside Embree and Mitsuba (docs/performance.md)
	cargo bench --bench stages
	benches/embree/run.sh
	benches/mitsuba/run.sh

intervals: ## count how often the 95 % intervals hold the truth (docs/tracer.md)
	cargo bench --bench intervals

chart: setup ## chart error against time, of the settled patch and of sparse beds (docs/performance.md)
	cargo build --release
	benches/mitsuba/run.sh --points docs/figures/chart_patch/mitsuba.csv
	target/release/soilsig chart scenes/settled_patch.json --beside docs/figures/chart_patch/mitsuba.csv \
	    --out docs/figures/chart_patch
	target/release/soilsig chart sparse --out docs/figures/chart_sparse

scale: setup ## chart what fields of 10^4 to 10^9 particles cost (docs/tracer.md)
	cargo run --release -- pipeline --coverage sparse
	python3 scripts/scale.py target/release/soilsig out/sparse/scene.json

packings: setup ## measure what packings differ by, and what is left of the tray (docs/geometry.md)
	cargo build --release
	python3 scripts/packings.py target/release/soilsig scenes/sparse.json 24 6000

tolerances: setup ## measure what planned runs cost and whether they hold: an hour and a half (docs/performance.md)
	cargo build --release
	python3 scripts/tolerances.py target/release/soilsig scenes/sparse.json out/tolerances .02 .01 .005 .002 .001

budgets: setup ## count how often the error budget holds, on recipes drawn at random (docs/performance.md)
	cargo build --release
	python3 scripts/budget.py target/release/soilsig 42 out/budgets.csv 3

facets: setup ## measure what facets of grains and fines are worth, in beds that lie already (docs/geometry.md)
	cargo build --release
	python3 scripts/facets.py target/release/soilsig 8

stress: setup ## drive the method to where it fails, and remake the atlas of docs/stability.md
	cargo build --release
	python3 scripts/stability.py target/release/soilsig

clean: ## remove what was built and installed here: target, .venv, .tools
	cargo clean
	rm -rf .venv .tools
