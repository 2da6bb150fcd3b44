#!/usr/bin/env bash
# Tests the npm package under Node.js, and the page in a headless Chromium, beside the program that renders the same.
# To be run after build.sh.
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

node --test npm/test.mjs page/test.mjs
