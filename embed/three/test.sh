#!/usr/bin/env bash
# Bakes a room and shows it by three.js in a headless Chromium: it must look as halfdome renders it.
#
# On Debian and Ubuntu it installs what is missing (as root, or by sudo): Chromium and Node.js.
set -euo pipefail
cd "$(dirname "$0")"

packages=()
command -v node > /dev/null || packages+=(nodejs npm)
[ -n "${CHROMIUM:-}" ] || command -v chromium > /dev/null || packages+=(chromium)
if [ ${#packages[@]} -gt 0 ]; then
    sudo=$([ "$(id -u)" -eq 0 ] || echo sudo)
    $sudo apt-get update
    $sudo apt-get install -y --no-install-recommends "${packages[@]}"
fi
npm install --no-package-lock --no-audit --no-fund --silent
cargo build --release -p halfdome
target=$(cargo metadata --format-version 1 --no-deps | sed 's/.*"target_directory":"\([^"]*\)".*/\1/')/release
HALFDOME=$target/halfdome node test.mjs
