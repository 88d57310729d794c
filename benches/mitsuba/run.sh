#!/bin/sh
# CPU time at equal standard error against Mitsuba 3 (docs/performance.md):
#   benches/mitsuba/run.sh [a placed scene with a floor; else one is made]
set -eu
cd "$(dirname "$0")/../.."
sh scripts/setup.sh bench
work=target/mitsuba
mkdir -p "$work"
scene=${1:-$work/bed/scene.json}
if [ ! -e "$scene" ]; then
    cargo run --release -- pipeline --coverage sparse --out "$work/bed"
fi
cargo bench --bench mitsuba -- "$scene" "$PWD/.tools/mitsuba/bin/python" "$work/open.json"
