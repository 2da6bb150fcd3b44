#!/usr/bin/env bash
# Builds the web page into embed/web/dist/, which any static server can show, and the WebAssembly of the npm package;
# `build.sh npm` the package alone, without the renderer; `build.sh simd` all but the page without SIMD, in half the time.
#
# On Debian and Ubuntu it installs what is missing (as root, or by sudo): wasm-opt, and Rust's library for the target.
set -euo pipefail
cd "$(dirname "$0")"

what=${1:-all}
case $what in
    all | npm | simd) ;;
    *) echo "usage: $0 [npm|simd]" >&2; exit 1 ;;
esac

../../.ci/install wasm-opt binaryen
rustup target add wasm32-unknown-unknown
# Wherever CARGO_TARGET_DIR or Cargo's configuration wants it.
base=$(cargo metadata --format-version 1 --no-deps | sed 's/.*"target_directory":"\([^"]*\)".*/\1/')

# Builds the package, and the page if it is asked for, with flags for the compiler and for wasm-opt, in a target folder of their
# own; file names get a suffix.
build() {
    local suffix=$1 flags=$2 optimizer=$3 page=$4
    local target=$base/wasm$suffix crates=(-p halfdome-npm)
    [ "$page" = no ] || crates+=(-p halfdome-page)
    RUSTFLAGS="$flags" cargo build --profile web --target wasm32-unknown-unknown --target-dir "$target" "${crates[@]}"
    local built=$target/wasm32-unknown-unknown/web
    local features="--enable-bulk-memory --enable-sign-ext --enable-nontrapping-float-to-int --enable-mutable-globals"
    # shellcheck disable=SC2086
    wasm-opt -O2 $features $optimizer "$built/halfdome_npm.wasm" -o "npm/halfdome$suffix.wasm"
    # Scenes need three times as much code: who wants trees alone does not load it. With the same crates, so that the kernel has
    # the same features and is not compiled anew.
    RUSTFLAGS="$flags" cargo build --profile web --target wasm32-unknown-unknown --target-dir "$target" "${crates[@]}" \
        --features halfdome-npm/scene
    # shellcheck disable=SC2086
    wasm-opt -O2 $features $optimizer "$built/halfdome_npm.wasm" -o "npm/halfdome-scene$suffix.wasm"
    [ "$page" = yes ] || return 0
    # shellcheck disable=SC2086
    wasm-opt -O2 $features $optimizer "$built/halfdome_page.wasm" -o "dist/page$suffix.wasm"
}

page=yes plain_page=yes
[ "$what" != npm ] || page=no
[ "$what" = all ] || plain_page=no
[ "$page" = no ] || { rm -rf dist && mkdir dist; }
# At a time, as link-time optimisation keeps one core busy.
build "" "" "" "$plain_page" &
plain=$!
build "-simd" "-C target-feature=+simd128" "--enable-simd" "$page"
wait "$plain"
if [ "$page" = yes ]; then
    cp page/index.html page/style.css page/*.js npm/simd.js dist/
    mkdir -p dist/moving/halfdome
    cp moving/index.html moving/*.js dist/moving/
    cp npm/index.js npm/engine.js npm/load.js npm/checks.js npm/simd.js npm/halfdome-scene*.wasm dist/moving/halfdome/
fi

printf '\n%-28s %9s %9s\n' "" bytes gzipped
files=(npm/*.wasm)
[ "$page" = no ] || files+=(dist/*.wasm)
for file in "${files[@]}"; do
    printf '%-28s %9d %9d\n' "$file" "$(stat -c %s "$file")" "$(gzip -9c "$file" | wc -c)"
done
[ "$page" = no ] || printf '%-28s %9d %9d\n' "page without WebAssembly" "$(cat dist/*.{html,css,js} | wc -c)" "$(cat dist/*.{html,css,js} | gzip -9c | wc -c)"
