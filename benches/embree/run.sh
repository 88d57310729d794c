#!/bin/sh
# Closest hits per second against Embree's single rays (docs/measurements/tracer_speed.md):
#   benches/embree/run.sh [PLACED_SCENE_WITH_PROTOTYPES]   (makes one if not given)
set -eu
cd "$(dirname "$0")/../.."
if [ ! -e /usr/include/embree3/rtcore.h ]; then
    [ "$(id -u)" = 0 ] && as= || as=sudo
    $as apt-get update -qq
    $as apt-get install -qq -y --no-install-recommends libembree-dev
fi
work=target/embree
mkdir -p "$work"
cc -O3 -march=native -Wall -Wextra benches/embree/closest_hits.c -o "$work/closest_hits" -lembree3 -lm
scene=${1:-$work/bed/scene.json}
if [ ! -e "$scene" ]; then
    cargo run --release -- pipeline --coverage sparse --out "$work/bed"
fi
cargo bench --bench hits -- "$scene" "$work/closest_hits"
