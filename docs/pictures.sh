#!/usr/bin/env bash
# Makes the README's pictures, in some six minutes on two cores. The kitchen is the model that ships inside the source of the
# crate obvhs, with a lamp put under its ceiling; needs python3 and zstd to unpack it.
set -euo pipefail
cd "$(dirname "$0")/.."
cargo build --release
halfdome=$PWD/target/release/halfdome
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

(cd "$work" && "$halfdome" --version && "$halfdome")
cp "$work/cornell.png" docs/cornell.png

"$halfdome" cubemap cornell --at 0.278,0.274,0.279 --spp 64 --size 128 --exposure -1 --seams lookup -o "$work/cubemap.png"
cp "$work/cubemap.png" docs/cubemap.png

# Where the ceiling has its light from the room alone: few records, without gradients and with them.
for gradients in off both; do
    "$halfdome" render cornell --integrator cached --metric split-sphere --cache-error 1 --record-rays 4096 \
        --gradients $gradients --eye 0.278,0.2,-0.25 --target 0.278,0.42,0.35 --vfov 62 --size 400x320 --spp 256 \
        --exposure 2 -o docs/gradients-$gradients.png
done

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
cargo run --release -p halfdome-benches --bin irradiance_curves -- cornell room "$work/kitchen.toml" --record-rays 2048 \
    --reference 8192 --plots "$work"
for scene in cornell room kitchen; do
    cp "$work/cache-$scene.svg" docs/validate-cache-$scene.svg
    cp "$work/cache-$scene-time.svg" docs/validate-cache-$scene-time.svg
done
"$halfdome" cache build "$work/kitchen.toml" -o "$work/kitchen.cache"
"$halfdome" cache show "$work/kitchen.toml" "$work/kitchen.cache" -o docs/records.png

# One scene by each integrator: a room like Cornell's, with a ball of mirror and a ball of glass.
python3 - "$work" <<'ROOM'
import math, sys
room = open(sys.argv[1] + "/room.obj", "w")
room.write("mtllib room.mtl\n")
vertices = 0

def faces(material, corners, polygons, normals=False):
    global vertices
    room.write(f"usemtl {material}\n")
    for corner in corners:
        room.write("v %.6f %.6f %.6f\n" % tuple(corner))
    for polygon in polygons:
        at = [vertices + i + 1 for i in polygon]
        room.write("f " + " ".join(f"{i}//{i - vertices}" if normals else f"{i}" for i in at) + "\n")
    vertices += len(corners)

def wall(material, *corners):
    faces(material, corners, [range(4)])

wall("white", (-1, -1, -1), (-1, -1, 1), (1, -1, 1), (1, -1, -1))
wall("white", (-1, 1, -1), (1, 1, -1), (1, 1, 1), (-1, 1, 1))
wall("white", (-1, -1, -1), (1, -1, -1), (1, 1, -1), (-1, 1, -1))
wall("red", (-1, -1, -1), (-1, 1, -1), (-1, 1, 1), (-1, -1, 1))
wall("green", (1, -1, -1), (1, -1, 1), (1, 1, 1), (1, 1, -1))
wall("lamp", (-0.3, 0.99, -0.3), (0.3, 0.99, -0.3), (0.3, 0.99, 0.3), (-0.3, 0.99, 0.3))
rings, sectors = 48, 96
unit = [(math.sin(t) * math.cos(p), math.cos(t), math.sin(t) * math.sin(p))
        for t in (math.pi * i / rings for i in range(rings + 1))
        for p in (2 * math.pi * j / sectors for j in range(sectors))]
quads = []
for i in range(rings):
    for j in range(sectors):
        a, b = i * sectors + j, i * sectors + (j + 1) % sectors
        # At the poles a side has no length.
        quads.append(([a, b] if i else [a]) + ([b + sectors, a + sectors] if i + 1 < rings else [a + sectors]))
for normal in unit:
    room.write("vn %.6f %.6f %.6f\n" % normal)
for material, center, radius in (("mirror", (-0.42, -0.6, -0.35), 0.4), ("glass", (0.42, -0.6, 0.3), 0.4)):
    points = [[c + radius * x for c, x in zip(center, normal)] for normal in unit]
    faces(material, points, quads, normals=True)
open(sys.argv[1] + "/room.mtl", "w").write("""newmtl white
Kd 0.75 0.75 0.75
newmtl red
Kd 0.75 0.1 0.08
newmtl green
Kd 0.1 0.6 0.12
newmtl lamp
Kd 0 0 0
Ke 14 13 11
newmtl mirror
Kd 0 0 0
Ks 0.95 0.95 0.95
illum 3
newmtl glass
Kd 0 0 0
Ni 1.5
illum 7
""")
ROOM
mkdir -p docs/integrators
picture() {
    "$halfdome" render "$work/room.obj" --size 240x240 --eye 0,0,3.8 --target 0,0,0 --vfov 39 -o "docs/integrators/$1.png" "${@:2}"
}
picture flat --integrator flat --spp 16
picture normals --integrator normals --spp 16
picture ao --integrator ao --spp 64
picture ao-hit-length --integrator ao --ao-weighting hit-length --spp 64
picture direct --integrator direct --spp 256
picture montecarlo --integrator montecarlo --bounces 1 --rays 8 --spp 128
picture naive --lights naive --spp 256
picture path --spp 1024
picture heat --integrator heat --spp 16
