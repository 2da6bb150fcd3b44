#!/usr/bin/env bash
# Draws the built-in scene on a Cortex-M4F in an emulator and on this machine: the pictures, and the checksums of all hits,
# must be the same. Prints what the firmware takes.
#
# On Debian and Ubuntu it installs what is missing (as root, or by sudo): the emulator, and Rust's library for the target.
# `embed/cortex-m/test.sh bake` writes cornell.bvh anew.
set -euo pipefail
cd "$(dirname "$0")"

../../.ci/install qemu-system-arm qemu-system-arm
rustup target add thumbv7em-none-eabihf
host=$(rustc -vV | sed -n 's/^host: //p')
out=$(mktemp -d)
trap 'rm -r "$out"' EXIT

# The tree in flash is the one that halfdome bakes today.
(cd ../.. && cargo run --release -p halfdome -- tree cornell -o "$out/cornell.bvh")
[ "${1:-}" != bake ] || cp "$out/cornell.bvh" cornell.bvh
cmp "$out/cornell.bvh" cornell.bvh

cargo run --release --locked --bin host --target "$host" > "$out/host.txt"
cargo run --release --locked --bin firmware > "$out/firmware.txt"
cat "$out/firmware.txt"
diff "$out/host.txt" <(grep -v '^#' "$out/firmware.txt")

# Bytes of the sections that are in flash, and of those that take RAM for good.
sections=$(readelf --sections --wide target/thumbv7em-none-eabihf/release/firmware)
size() {
    local name sum=0
    for name in "$@"; do
        sum=$((sum + 0x$(sed -n "s/^ *\[ *[0-9]*\] \\$name  *[A-Z]*  *[0-9a-f]* [0-9a-f]* \([0-9a-f]*\) .*/\1/p" <<< "$sections")))
    done
    echo $sum
}
echo "# flash: $(size .vector_table .text .rodata .data) bytes, of which code $(size .text); static RAM: $(size .data .bss) bytes"
echo "The microcontroller draws what this machine draws."
