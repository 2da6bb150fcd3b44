#!/usr/bin/env bash
# Bakes a room and shows it by three.js in a headless Chromium: it must look as halfdome renders it.
set -euo pipefail
cd "$(dirname "$0")"

../../.ci/install node "nodejs npm" "${CHROMIUM:-chromium}" chromium
npm install --no-package-lock --no-audit --no-fund --silent
cargo build --release -p halfdome
target=$(cargo metadata --format-version 1 --no-deps | sed 's/.*"target_directory":"\([^"]*\)".*/\1/')/release
HALFDOME=$target/halfdome node test.mjs
