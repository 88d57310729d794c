#!/bin/sh
# Mitsuba 3 beside soilsig (docs/tracer_speed.md). CPU time at equal standard error:
#   benches/mitsuba/run.sh [a placed scene with a floor; else one is made]
# Mitsuba's points in the chart of a scene, for `soilsig chart --beside` (paths are from the repository's root):
#   benches/mitsuba/run.sh --points FILE.csv [a placed scene with a floor; else the shipped patch]
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
