#!/usr/bin/env bash
# Counts the instructions of the kernel's hot paths in Valgrind (benches/benches/instructions.rs) and fails where they exceed
# their limits.
#
# On Debian and Ubuntu it installs Valgrind if it is missing (as root, or by sudo); gungraun's program goes into
# target/tools.
set -euo pipefail
cd "$(dirname "$0")/.."

if ! command -v valgrind > /dev/null; then
    sudo=$([ "$(id -u)" -eq 0 ] || echo sudo)
    $sudo apt-get update
    $sudo apt-get install -y --no-install-recommends valgrind
fi
version=$(grep -A 1 '^name = "gungraun-runner"' Cargo.lock | sed -n 's/^version = "\(.*\)"/\1/p')
cargo install gungraun-runner --version "$version" --locked --root target/tools
GUNGRAUN_RUNNER=$PWD/target/tools/bin/gungraun-runner cargo bench -p halfdome-benches --features instructions --bench instructions
