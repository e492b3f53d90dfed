#!/usr/bin/env bash
# Runs every fuzz target for some seconds from its committed corpus, with the stable compiler; what it finds fails.
# usage: tests/fuzz/run.sh [SECONDS [TARGET ...]]     default 30 s, all targets; needs a C++ compiler
set -euo pipefail
cd "$(dirname "$0")"
seconds=${1:-30}
shift || true
targets=("$@")
[ "${#targets[@]}" -gt 0 ] || targets=($(basename -s .rs -a fuzz_targets/*.rs))
host=$(rustc -vV | sed -n 's/^host: //p')
# What cargo-fuzz asks of a nightly compiler but for the sanitizers: counters at every edge, for libFuzzer to follow.
export RUSTFLAGS="--cfg fuzzing -Cpasses=sancov-module -Cllvm-args=-sanitizer-coverage-level=4 \
-Cllvm-args=-sanitizer-coverage-inline-8bit-counters -Cllvm-args=-sanitizer-coverage-pc-table"
export CARGO_PROFILE_RELEASE_OPT_LEVEL=1 CARGO_PROFILE_RELEASE_DEBUG_ASSERTIONS=true
cargo build --quiet --release --target "$host" --target-dir ../../target/fuzz
# One target. The corpus grows in a folder of its own; seed and limits are stated, so that a finding can be repeated.
run_target() {
    local target=$1 work
    work=$(mktemp -d)
    if ! "$programs/$target" "$work" "corpus/$target" -max_total_time="$seconds" -seed=1 -timeout=10 \
        -rss_limit_mb=2048 -artifact_prefix="$work/" > "$work/log" 2>&1; then
        echo "fuzz target $target found something; its input is in $work"
        tail -n 25 "$work/log"
        return 1
    fi
    echo "fuzz target $target: $(grep -c . "$work/log") lines, $(sed -n 's/^Done \([0-9]*\) runs.*/\1/p' "$work/log") runs"
    rm -rf "$work"
}
export programs="../../target/fuzz/$host/release" seconds
export -f run_target
# One target a processor; xargs fails when one of them did.
printf '%s\n' "${targets[@]}" | xargs -P "$(nproc)" -I '{}' bash -c 'run_target {}'
