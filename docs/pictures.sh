#!/usr/bin/env bash
# Makes the README's pictures, in some four minutes on two cores. The kitchen is the model that ships inside the source of the
# crate obvhs, with a lamp put under its ceiling; needs python3 and zstd to unpack it.
set -euo pipefail
cd "$(dirname "$0")/.."
cargo build --release
halfdome=$PWD/target/release/halfdome
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

(cd "$work" && "$halfdome" --version && "$halfdome")
cp "$work/cornell.png" docs/cornell.png

"$halfdome" validate --plots "$work/figures" furnace convergence
for figure in furnace-bounces furnace-survival furnace-variance convergence-ao convergence-direct convergence-strata; do
    cp "$work/figures/$figure.svg" "docs/validate-${figure#furnace-}.svg"
done

assets=$(cargo metadata --format-version 1 | python3 -c '
import json, os, sys
packages = json.load(sys.stdin)["packages"]
print(os.path.dirname(next(p["manifest_path"] for p in packages if p["name"] == "obvhs")) + "/assets")')
zstd --decompress --quiet "$assets/kitchen.obj.zst" -o "$work/kitchen.obj"
cp "$assets/kitchen.mtl" "$work"
vertices=$(grep -c '^v ' "$work/kitchen.obj")
cat >> "$work/kitchen.obj" <<LAMP
mtllib lamp.mtl
o lamp
usemtl lamp
v 0.2 2.35 -0.4
v 1.0 2.35 -0.4
v 1.0 2.35 0.4
v 0.2 2.35 0.4
f $((vertices + 1)) $((vertices + 2)) $((vertices + 3)) $((vertices + 4))
LAMP
printf 'newmtl lamp\nKd 0 0 0\nKe 12 11 9\n' > "$work/lamp.mtl"
cat > "$work/kitchen.toml" <<SCENE
[scene]
file = "kitchen.obj"
[camera]
eye = [2.6, 1.6, 2.2]
target = [-0.4, 0.9, -1.2]
vfov = 55
[film]
width = 640
height = 400
filter = "mitchell"
[render]
spp = 512
[sky]
radiance = [2.0, 2.4, 3.0]
SCENE
"$halfdome" render "$work/kitchen.toml" -o docs/kitchen.png --tone neutral --exposure 0.5
