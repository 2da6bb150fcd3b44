#!/usr/bin/env bash
# Makes docs/caustics.png, in about five minutes on two cores: a ball, a drinking glass, a bottle and a prism, and what they
# do to the light of a lamp.
set -euo pipefail
cd "$(dirname "$0")/.."
cargo build --release
halfdome=$PWD/target/release/halfdome
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

python3 - "$work" <<'GLASS'
import math, sys
lines = ["mtllib table.mtl"]
corners = 0

def surface(name, profile, place, around=96):
    """Turns a profile of (radius, height, normal's radius and height) about an axis."""
    global corners
    lines.append("o %s\nusemtl %s" % (name, name))
    for step in range(around):
        a = 2 * math.pi * step / around
        for r, y, nr, ny in profile:
            lines.append("v %.6f %.6f %.6f" % (place[0] + r * math.cos(a), place[1] + y, place[2] + r * math.sin(a)))
            lines.append("vn %.6f %.6f %.6f" % (nr * math.cos(a), ny, nr * math.sin(a)))
    count = len(profile)
    for step in range(around):
        for i in range(count - 1):
            a, b = step * count + i, step * count + i + 1
            c, d = [(at + count) % (around * count) for at in (b, a)]
            face = [corners + 1 + at for at in (a, b, c, d)]
            lines.append("f " + " ".join("%d//%d" % (at, at) for at in face))
    corners += around * count

def smooth(points, steps=12):
    """A Catmull-Rom spline through points, with its normals to the right."""
    profile = []
    ends = [points[0]] + points + [points[-1]]
    for before, a, b, after in zip(ends, ends[1:], ends[2:], ends[3:]):
        for step in range(steps + (b is points[-1])):
            t = step / steps
            at, by = [], []
            for k in range(2):
                c = ((b[k] - before[k]) / 2, (after[k] - a[k]) / 2)
                u = (2 * a[k] - 2 * b[k] + c[0] + c[1], -3 * a[k] + 3 * b[k] - 2 * c[0] - c[1], c[0], a[k])
                at.append(((u[0] * t + u[1]) * t + u[2]) * t + u[3])
                by.append((3 * u[0] * t + 2 * u[1]) * t + u[2])
            length = math.hypot(*by) or 1
            profile.append((max(at[0], 0), at[1], by[1] / length, -by[0] / length))
    return profile

ball = [(math.sin(a), 1 - math.cos(a), math.sin(a), -math.cos(a)) for a in (math.pi * i / 64 for i in range(65))]
surface("ball", [(0.11 * r, 0.11 * y, nr, ny) for r, y, nr, ny in ball], (-0.32, 0.0005, 0.02))
# Up on the outside, down on the inside.
surface("tumbler", smooth([(0, 0), (0.03, 0), (0.034, 0.004), (0.037, 0.05), (0.041, 0.13)])
        + smooth([(0.041, 0.13), (0.0395, 0.132), (0.038, 0.13)], 4)
        + smooth([(0.038, 0.13), (0.035, 0.05), (0.032, 0.014), (0.028, 0.01), (0, 0.01)]), (-0.05, 0.0005, 0.1))
surface("bottle", smooth([(0, 0), (0.05, 0), (0.055, 0.006), (0.056, 0.1), (0.052, 0.15), (0.022, 0.2), (0.018, 0.27)])
        + smooth([(0.018, 0.27), (0.016, 0.272), (0.014, 0.27)], 4)
        + smooth([(0.014, 0.27), (0.018, 0.2), (0.046, 0.148), (0.05, 0.1), (0.049, 0.016), (0.04, 0.01), (0, 0.014)]),
        (0.2, 0.0005, -0.02))
lines.append("o prism\nusemtl prism")
first = corners
turn = 0.5
for x in (-0.09, 0.09):
    for y, z in ((0.0005, -0.05), (0.0005, 0.05), (0.087, 0)):
        lines.append("v %.6f %.6f %.6f" % (0.17 + x * math.cos(turn) - z * math.sin(turn), y, 0.2 + x * math.sin(turn) + z * math.cos(turn)))
for face in ((1, 2, 3), (4, 6, 5), (1, 4, 5, 2), (2, 5, 6, 3), (3, 6, 4, 1)):
    lines.append("f " + " ".join(str(first + at) for at in face))
lines.append("o table\nusemtl table")
for x, z in ((-3, -3), (-3, 3), (3, 3), (3, -3)):
    lines.append("v %d 0 %d" % (x, z))
lines.append("f -4 -3 -2 -1")
open(sys.argv[1] + "/table.obj", "w").write("\n".join(lines) + "\n")
GLASS

cat > "$work/table.mtl" <<'MTL'
newmtl table
Kd 0.55 0.5 0.45
newmtl ball
illum 7
Ni 1.5
newmtl tumbler
illum 7
Ni 1.5
newmtl bottle
illum 7
Ni 1.5
Tf 0.55 0.9 0.65
newmtl prism
illum 7
Ni 1.6
MTL
cat > "$work/scene.toml" <<'SCENE'
[scene]
file = "table.obj"

[sky]
radiance = [0.1, 0.12, 0.15]

[camera]
eye = [0.0, 0.62, 0.95]
target = [-0.02, 0.03, 0.07]
vfov = 34

[[light]]
type = "point"
position = [-0.35, 0.9, -0.75]
power = 30
radius = 0.012
SCENE
"$halfdome" render "$work/scene.toml" --size 960x540 --spp "${SPP:-256}" --exposure "${EXPOSURE:-0}" -o "${OUT:-docs/caustics.png}"
