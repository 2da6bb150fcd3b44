#!/usr/bin/env bash
# The kernel's unit tests on the portable backend in Miri, which finds undefined behaviour, and blobs on a big-endian
# machine, which it is too if asked. In Miri tests take fewer rays and triangles; those that need thousands are left out.
#
#     tests/miri.sh [filter of tests...]
#
# Installs Miri in the nightly toolchain if it is missing.
set -euo pipefail
cd "$(dirname "$0")/.."

rustup run nightly rustc --version || rustup toolchain install nightly --profile minimal
rustup component add miri rust-src --toolchain nightly

filter=("$@")
[ ${#filter[@]} -gt 0 ] || filter=(
    bvh::blob bvh::build bvh::node geometry simd traverse::tests::an_empty_tree traverse::tests::limits::corners_on_a_line
    traverse::visits::tests::one_node
)
export MIRIFLAGS=-Zmiri-strict-provenance
cargo +nightly miri test -p halfdome-kernel --lib -- "${filter[@]}"
cargo +nightly miri test -p halfdome-kernel --lib --target s390x-unknown-linux-gnu -- bvh::blob
printf '\nMiri found nothing, in %s s.\n' "$SECONDS"
