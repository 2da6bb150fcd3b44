#!/usr/bin/env bash
# Tests the npm package under Node.js and in bundles, and the pages in a headless Chromium, beside the program that renders the same.
# To be run after build.sh.
set -euo pipefail
cd "$(dirname "$0")"

../../.ci/install node "nodejs npm" "${CHROMIUM:-chromium}" chromium
npm install --no-package-lock --no-audit --no-fund --silent
cargo build --release -p halfdome
target=$(cargo metadata --format-version 1 --no-deps | sed 's/.*"target_directory":"\([^"]*\)".*/\1/')/release

HALFDOME=${HALFDOME:-$target/halfdome} node --test npm/*.mjs page/test.mjs moving/test.mjs
