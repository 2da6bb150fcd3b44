#!/usr/bin/env bash
# Makes the pictures of denoising in render.md: the Cornell box with 8 samples a pixel, and the same denoised by nlm.
set -euo pipefail
cd "$(dirname "$0")/.."
cargo build --release
halfdome=${HALFDOME:-target/release/halfdome}
options="render cornell --size 256x256 --spp 8 --progress none"
# shellcheck disable=SC2086
"$halfdome" $options -o docs/denoise-noisy.png
# shellcheck disable=SC2086
"$halfdome" $options --denoise nlm -o docs/denoise-nlm.png
