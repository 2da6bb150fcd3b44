#!/usr/bin/env bash
# Counts the instructions of the kernel's hot paths in Valgrind (benches/src/bin/instructions.rs) and fails where they exceed
# their limits.
#
# On Debian and Ubuntu it installs Valgrind if it is missing (as root, or by sudo).
set -euo pipefail
cd "$(dirname "$0")/.."

.ci/install valgrind valgrind
cargo run --release -p halfdome-benches --bin instructions
