#!/usr/bin/env bash
# Makes the two pictures of path guiding in render.md, in about two minutes on two cores: a dark room, whose door is a hand's
# breadth open to a corridor with a lamp that nobody in the room sees.
set -euo pipefail
cd "$(dirname "$0")/.."
cargo build --release
halfdome=$PWD/target/release/halfdome
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

python3 - "$work" <<'DOOR'
import math, sys
corners, faces = [], []

def quad(material, *points):
    first = len(corners) + 1
    corners.extend(points)
    faces.append((material, range(first, first + 4)))

def box(material, low, high):
    (a, b, c), (d, e, f) = low, high
    quad(material, (a, b, c), (d, b, c), (d, b, f), (a, b, f))
    quad(material, (a, e, c), (a, e, f), (d, e, f), (d, e, c))
    quad(material, (a, b, c), (a, b, f), (a, e, f), (a, e, c))
    quad(material, (d, b, c), (d, e, c), (d, e, f), (d, b, f))
    quad(material, (a, b, c), (a, e, c), (d, e, c), (d, b, c))
    quad(material, (a, b, f), (d, b, f), (d, e, f), (a, e, f))

# A room of 5 by 4 metres and a corridor of 2 by 4, 2.6 m high, and a doorway of 1 by 2.1 m between them.
top = 2.6
quad("floor", (0, 0, 0), (0, 0, 4), (7, 0, 4), (7, 0, 0))
quad("white", (0, top, 0), (7, top, 0), (7, top, 4), (0, top, 4))
quad("red", (0, 0, 0), (0, top, 0), (0, top, 4), (0, 0, 4))
quad("white", (7, 0, 0), (7, 0, 4), (7, top, 4), (7, top, 0))
quad("white", (0, 0, 0), (7, 0, 0), (7, top, 0), (0, top, 0))
quad("blue", (0, 0, 4), (0, top, 4), (7, top, 4), (7, 0, 4))
box("white", (4.95, 0, 0), (5.05, top, 1.5))
box("white", (4.95, 0, 2.5), (5.05, top, 4))
box("white", (4.95, 2.1, 1.5), (5.05, top, 2.5))
angle = math.radians(14)
along, across = (-math.sin(angle), math.cos(angle)), (math.cos(angle), math.sin(angle))
door = [(5 + s * along[0] + t * across[0], 1.5 + s * along[1] + t * across[1])
        for s, t in ((0, -0.02), (0.99, -0.02), (0.99, 0.02), (0, 0.02))]
low, high = [[(x, y, z) for x, z in door] for y in (0, 2.09)]
for i in range(4):
    quad("wood", low[i], low[(i + 1) % 4], high[(i + 1) % 4], high[i])
quad("wood", *high)
box("wood", (1.5, 0, 1.2), (2.7, 0.7, 2.2))
box("blue", (1.8, 0.7, 1.5), (2.1, 1, 1.8))
box("white", (3.2, 0, 3), (4, 1.6, 3.8))
box("lamp", (5.6, top - 0.1, 0.1), (6.4, top - 0.05, 0.5))
with open(sys.argv[1] + "/door.obj", "w") as model:
    model.write("mtllib door.mtl\n" + "".join("v %.5f %.5f %.5f\n" % corner for corner in corners))
    model.write("".join("usemtl %s\nf %d %d %d %d\n" % (material, *numbers) for material, numbers in faces))
with open(sys.argv[1] + "/door.mtl", "w") as materials:
    for name, color, light in (("floor", "0.5 0.4 0.3", 0), ("white", "0.75 0.75 0.75", 0), ("red", "0.6 0.2 0.15", 0),
                               ("blue", "0.2 0.3 0.6", 0), ("wood", "0.55 0.35 0.2", 0), ("lamp", "0 0 0", 1)):
        materials.write(f"newmtl {name}\nKd {color}\n" + "Ke 60 55 45\n" * light)
DOOR

# As many samples as take about the same time.
picture() {
    "$halfdome" render "$work/door.obj" --eye 0.5,1.6,0.6 --target 4.2,0.9,2.4 --vfov 60 --size 480x360 \
        --tone neutral --exposure 4.5 -o "docs/$1.png" "${@:2}"
}
time picture guide-off --spp 300
time picture guide-on --spp 100 --guide
