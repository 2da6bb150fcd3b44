#!/usr/bin/env bash
# The kernel's tests on the targets that this machine is not: 64-bit Arm in an emulator, and WebAssembly, plain and with
# SIMD. Among them are the checksums of hits, trees and numbers in tests/checksums, which are the same on each target.
#
#     tests/targets.sh [arm] [wasm]      (both if neither is named)
#
# On Debian and Ubuntu it installs what is missing (as root, or by sudo): an emulator, a cross linker, Node.js, and
# Rust's libraries for the targets.
set -euo pipefail
cd "$(dirname "$0")/.."

targets=("$@")
[ ${#targets[@]} -gt 0 ] || targets=(arm wasm)

# The tests on a target, with these flags for the compiler and these features. A folder of its own, so that other builds need
# not wait.
run() {
    printf '\n== %s %s\n' "$1" "$2"
    RUSTFLAGS="$2" cargo test --release -p halfdome-kernel --features "$3" --lib --target "$1" \
        --target-dir target/targets
}

export CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_LINKER=aarch64-linux-gnu-gcc
export CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_RUNNER="qemu-aarch64 -L /usr/aarch64-linux-gnu"
CARGO_TARGET_WASM32_WASIP1_RUNNER="node --no-warnings $PWD/tests/wasi.mjs"
export CARGO_TARGET_WASM32_WASIP1_RUNNER

for target in "${targets[@]}"; do
    case $target in
    arm)
        rustup target add aarch64-unknown-linux-gnu
        .ci/install qemu-aarch64 qemu-user aarch64-linux-gnu-gcc "gcc-aarch64-linux-gnu libc6-dev-arm64-cross"
        # Random tests take a twentieth of their rays.
        HALFDOME_EMULATED=yes run aarch64-unknown-linux-gnu "" rayon,obvhs
        ;;
    wasm)
        rustup target add wasm32-wasip1
        .ci/install node nodejs
        run wasm32-wasip1 "" default
        run wasm32-wasip1 "-C target-feature=+simd128" default
        ;;
    *)
        echo "error: there is no target $target: say arm or wasm" >&2
        exit 1
        ;;
    esac
done
printf '\nAll targets agree, in %s s.\n' "$SECONDS"
