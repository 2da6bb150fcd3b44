#!/usr/bin/env bash
# Bakes two rooms whose light is known, and shows them by Bevy without a window: the lightmaps must be there, and pixels must
# have the right value.
#
# On Debian and Ubuntu it installs what is missing (as root, or by sudo): a Vulkan driver that needs no graphics card.
set -euo pipefail
cd "$(dirname "$0")"

ls /usr/share/vulkan/icd.d/*.json > /dev/null 2>&1 || ../../.ci/install "a Vulkan driver" "libvulkan1 mesa-vulkan-drivers"
cargo test --locked "$@"
