#!/usr/bin/env bash
# Builds the web page into embed/web/dist/, which any static server can show, and the WebAssembly of the npm package;
# `build.sh npm` the package alone, without the renderer.
#
# On Debian and Ubuntu it installs what is missing (as root, or by sudo): wasm-opt, and Rust's library for the target.
set -euo pipefail
cd "$(dirname "$0")"

what=${1:-all}
case $what in
    all) crates=(-p halfdome-npm -p halfdome-page) ;;
    npm) crates=(-p halfdome-npm) ;;
    *) echo "usage: $0 [npm]" >&2; exit 1 ;;
esac

../../.ci/install wasm-opt binaryen
rustup target add wasm32-unknown-unknown
# Wherever CARGO_TARGET_DIR or Cargo's configuration wants it.
base=$(cargo metadata --format-version 1 --no-deps | sed 's/.*"target_directory":"\([^"]*\)".*/\1/')

# Builds both crates with flags for the compiler and for wasm-opt, in a target folder of their own; file names get a suffix.
build() {
    local suffix=$1 flags=$2 optimizer=$3
    local target=$base/wasm$suffix
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
    [ "$what" = all ] || return 0
    # shellcheck disable=SC2086
    wasm-opt -O2 $features $optimizer "$built/halfdome_page.wasm" -o "dist/page$suffix.wasm"
}

[ "$what" = npm ] || { rm -rf dist && mkdir dist; }
# At a time, as link-time optimisation keeps one core busy.
build "" "" "" &
plain=$!
build "-simd" "-C target-feature=+simd128" "--enable-simd"
wait "$plain"
if [ "$what" = all ]; then
    cp page/index.html page/style.css page/*.js npm/simd.js dist/
    mkdir -p dist/moving/halfdome
    cp moving/index.html moving/*.js dist/moving/
    cp npm/index.js npm/engine.js npm/checks.js npm/simd.js npm/halfdome-scene*.wasm dist/moving/halfdome/
fi

printf '\n%-28s %9s %9s\n' "" bytes gzipped
files=(npm/*.wasm)
[ "$what" = npm ] || files+=(dist/*.wasm)
for file in "${files[@]}"; do
    printf '%-28s %9d %9d\n' "$file" "$(stat -c %s "$file")" "$(gzip -9c "$file" | wc -c)"
done
[ "$what" = npm ] || printf '%-28s %9d %9d\n' "page without WebAssembly" "$(cat dist/*.{html,css,js} | wc -c)" "$(cat dist/*.{html,css,js} | gzip -9c | wc -c)"
