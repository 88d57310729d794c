#!/bin/sh
# Gives each parser of tests/it/fuzz/parsers.rs inputs that libFuzzer makes by coverage, on stable
# Rust. A panic, 30 s for an input and too much memory end it; the input is in fuzz/found then.
#
# scripts/fuzz.sh BYTES [PARSER ...]
set -eu

bytes=$1
shift
cd "$(dirname "$0")/.."
host=$(rustc -vV | sed -n 's/^host: //p')
program=fuzz/target/$host/release/soilsig-fuzz
coverage="-Cpasses=sancov-module -Cllvm-args=-sanitizer-coverage-level=4
    -Cllvm-args=-sanitizer-coverage-inline-8bit-counters
    -Cllvm-args=-sanitizer-coverage-pc-table -Cllvm-args=-sanitizer-coverage-trace-compares"
# The same versions as in the program.
cp Cargo.lock fuzz/Cargo.lock
# With --target the flags do not reach build scripts.
RUSTFLAGS="$coverage --cfg fuzzing" \
    cargo build --quiet --release --manifest-path fuzz/Cargo.toml --target "$host"
[ $# -gt 0 ] || set -- $("$program" 2>&1 | sed -n 's/^parsers: //p')
mkdir -p fuzz/corpus fuzz/found
status=0
for parser in "$@"; do
    log=fuzz/corpus/$parser.log
    SOILSIG_FUZZ=$parser SOILSIG_FUZZ_BYTES=$bytes "$program" "fuzz/corpus/$parser" \
        -max_len=65536 -len_control=0 -timeout=30 -rss_limit_mb=2048 \
        -artifact_prefix="fuzz/found/$parser-" 2> "$log" || {
        status=1
        echo "$parser: FOUND, see $log"
    }
done
exit $status
