#!/usr/bin/env bash
# Runs all fuzzers, one after the other, for so many minutes each (fractions allowed). What they find stays in
# tests/fuzz/artifacts; inputs that reach new code, in tests/fuzz/corpus.
#
#     tests/fuzz/run.sh MINUTES [FUZZER...]
#
# Installs a nightly toolchain and cargo-fuzz if they are missing.
set -euo pipefail
cd "$(dirname "$0")/../.."

minutes=${1:?"how many minutes each?"}
shift
fuzzers=("$@")
[ ${#fuzzers[@]} -gt 0 ] || fuzzers=(blobs differential round trees)
seconds=$(awk -v minutes="$minutes" 'BEGIN { printf "%d", minutes * 60 }')
[ "$seconds" -gt 0 ] || { echo "error: more than no time is needed" >&2; exit 1; }

rustup run nightly rustc --version || rustup toolchain install nightly --profile minimal
cargo fuzz --version || cargo install cargo-fuzz --locked --debug

for fuzzer in "${fuzzers[@]}"; do
    printf '\n== %s\n' "$fuzzer"
    cargo +nightly fuzz run --fuzz-dir tests/fuzz "$fuzzer" -- \
        -max_total_time="$seconds" -max_len=4096 -len_control=0 -timeout=60 -verbosity=0 -print_final_stats=1
done
