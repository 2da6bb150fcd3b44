#!/usr/bin/env bash
# Makes the pictures of cameras in render.md, in about two minutes on two cores: a hall with balls and little lamps.
set -euo pipefail
cd "$(dirname "$0")/.."
cargo build --release
halfdome=$PWD/target/release/halfdome
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

python3 - "$work" <<'HALL'
import math, sys
hall = open(sys.argv[1] + "/hall.obj", "w")
hall.write("mtllib hall.mtl\n")
vertices = 0

def faces(material, corners, polygons, normals=()):
    global vertices
    hall.write(f"usemtl {material}\n")
    for corner in corners:
        hall.write("v %.5f %.5f %.5f\n" % tuple(corner))
    for normal in normals:
        hall.write("vn %.5f %.5f %.5f\n" % tuple(normal))
    for polygon in polygons:
        at = [vertices + i + 1 for i in polygon]
        hall.write("f " + " ".join(f"{i}//{i - vertices + balls}" if normals else f"{i}" for i in at) + "\n")
    vertices += len(corners)

balls = 0
def wall(material, *corners):
    faces(material, corners, [range(4)])

# 4 m wide, 3 m high, 12 m long, along -z.
wall("white", (-2, 3, 2), (-2, 3, -10), (2, 3, -10), (2, 3, 2))
wall("white", (-2, 0, -10), (2, 0, -10), (2, 3, -10), (-2, 3, -10))
wall("white", (2, 0, 2), (-2, 0, 2), (-2, 3, 2), (2, 3, 2))
wall("red", (-2, 0, 2), (-2, 0, -10), (-2, 3, -10), (-2, 3, 2))
wall("green", (2, 0, -10), (2, 0, 2), (2, 3, 2), (2, 3, -10))
for i in range(8):
    for j in range(24):
        x, z = -2 + 0.5 * i, 2 - 0.5 * j
        wall("white" if (i + j) % 2 else "dark", (x, 0, z), (x + 0.5, 0, z), (x + 0.5, 0, z - 0.5), (x, 0, z - 0.5))
for z in (-7, -3, 1):
    wall("lamp", (-0.6, 2.99, z), (-0.6, 2.99, z - 0.6), (0.6, 2.99, z - 0.6), (0.6, 2.99, z))
rings, sectors = 24, 48
unit = [(math.sin(t) * math.cos(p), math.cos(t), math.sin(t) * math.sin(p))
        for t in (math.pi * i / rings for i in range(rings + 1))
        for p in (2 * math.pi * j / sectors for j in range(sectors))]
quads = []
for i in range(rings):
    for j in range(sectors):
        a, b = i * sectors + j, i * sectors + (j + 1) % sectors
        quads.append(([a, b] if i else [a]) + ([b + sectors, a + sectors] if i + 1 < rings else [a + sectors]))

def ball(material, center, radius):
    global balls
    balls += len(unit)
    base = balls - len(unit)
    points = [[c + radius * x for c, x in zip(center, normal)] for normal in unit]
    keep, balls = balls, base
    faces(material, points, quads, unit)
    balls = keep

for i, (x, z) in enumerate(((-0.75, -1.2), (-0.25, -2.2), (0.3, -3.4), (0.9, -5), (1.4, -7))):
    ball(("blue", "gold", "blue", "gold", "blue")[i], (x, 0.35, z), 0.35)
for i in range(16):
    ball("spark", (-1.9 + 3.8 * (i * 0.618 % 1), 1.1 + 1.7 * (i * 0.414 % 1), -6 - 3.8 * (i * 0.755 % 1)), 0.02)
open(sys.argv[1] + "/hall.mtl", "w").write("""newmtl white
Kd 0.7 0.7 0.68
newmtl dark
Kd 0.12 0.13 0.15
newmtl red
Kd 0.6 0.12 0.08
newmtl green
Kd 0.12 0.45 0.15
newmtl blue
Kd 0.08 0.2 0.6
newmtl gold
Kd 0.7 0.45 0.1
newmtl lamp
Kd 0 0 0
Ke 6 5.6 5
newmtl spark
Kd 0 0 0
Ke 500 400 240
""")
HALL
picture() {
    "$halfdome" render "$work/hall.obj" --tone neutral --clamp-indirect 5 -o "docs/cameras/$1.png" "${@:2}"
}
mkdir -p docs/cameras
view="--eye -0.3,1.3,1.2 --target 0.05,0.75,-2.2"
picture lens $view --size 300x200 --spp 512 --focal-length 40 --aperture 250 --focus-at -0.25,0.35,-2.2 --blades 6
picture fisheye $view --camera fisheye --fov 220 --size 200x200 --spp 256
picture panorama --eye 0,1.3,-2.5 --target 0,1.3,-9 --camera panorama --size 400x200 --spp 256
