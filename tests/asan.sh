#!/usr/bin/env bash
# The kernel's unit tests, on all instruction sets that the machine has, with AddressSanitizer: no access out of bounds.
#
#     tests/asan.sh [filter of tests...]
#
# Installs a nightly toolchain if there is none.
set -euo pipefail
cd "$(dirname "$0")/.."

rustup run nightly rustc --version || rustup toolchain install nightly --profile minimal
filter=("$@")
[ ${#filter[@]} -gt 0 ] || filter=(bvh geometry irradiance simd traverse)
# A target of its own keeps build scripts and macros out of it.
RUSTFLAGS="-Zsanitizer=address" cargo +nightly test --release -p halfdome-kernel --lib \
    --target x86_64-unknown-linux-gnu --target-dir target/asan -- "${filter[@]}"
printf '\nAddressSanitizer found nothing, in %s s.\n' "$SECONDS"
