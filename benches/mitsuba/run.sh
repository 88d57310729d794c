#!/bin/sh
# Mitsuba 3 against soilsig (docs/measurements/tracer_speed.md). CPU time at equal standard error:
#   benches/mitsuba/run.sh [PLACED_SCENE_WITH_FLOOR]                    (makes one if not given)
# Mitsuba's points for `soilsig chart --beside`; paths are relative to the repository's root:
#   benches/mitsuba/run.sh --points FILE.csv [PLACED_SCENE_WITH_FLOOR]  (default: shipped patch)
set -eu
cd "$(dirname "$0")/../.."
sh scripts/setup.sh bench
work=target/mitsuba
mkdir -p "$work"
python=$PWD/.tools/mitsuba/bin/python
if [ "${1:-}" = --points ]; then
    exec cargo bench --bench mitsuba -- "${3:-scenes/settled_patch.json}" "$python" "$work/points.json" "$2"
fi
scene=${1:-$work/bed/scene.json}
if [ ! -e "$scene" ]; then
    cargo run --release -- pipeline --coverage sparse --out "$work/bed"
fi
cargo bench --bench mitsuba -- "$scene" "$python" "$work/open.json"
