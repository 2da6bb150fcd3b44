#!/usr/bin/env bash
# Makes docs/forest.png: 10,000 spruces of a million triangles each. The tree is grown here: needles along branches that
# spiral up a trunk.
set -euo pipefail
cd "$(dirname "$0")/.."
halfdome=${HALFDOME:-target/release/halfdome}
[ -x "$halfdome" ] || cargo build --release
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

awk -v needles="${NEEDLES:-498000}" 'BEGIN {
    srand(1); pi = atan2(0, -1)
    print "mtllib spruce.mtl"
    # The trunk: a cone of 16 sides.
    for (i = 0; i < 16; i++) {
        a = 2 * pi * i / 16
        printf "v %.4f 0 %.4f\n", 0.22 * cos(a), 0.22 * sin(a)
    }
    print "v 0 12 0\nusemtl bark"
    for (i = 1; i <= 16; i++) print "f", i, 17, i % 16 + 1
    print "usemtl needle"
    branches = 300; each = int(needles / branches)
    for (b = 0; b < branches; b++) {
        h = 0.6 + 11.2 * (b + rand()) / branches
        reach = (12 - h) * 0.27 * (0.8 + 0.4 * rand()) + 0.1
        a = b * 2.39996 + 0.4 * rand()
        for (n = 0; n < each; n++) {
            # Along the branch, which hangs and lifts its tip; twigs leave it to both sides.
            s = sqrt(rand()); side = (rand() - 0.5) * 0.9 * reach * (1 - 0.75 * s)
            r = reach * s; y = h - 0.35 * r + 0.12 * r * r - 0.25 * side * side / (reach + 0.1) + 0.04 * (rand() - 0.5)
            x = r * cos(a) - side * sin(a); z = r * sin(a) + side * cos(a)
            t = 2 * pi * rand(); l = 0.05 + 0.05 * rand(); u = 0.07 * (rand() - 0.35)
            dx = l * cos(t); dz = l * sin(t); w = 0.006
            printf "v %.4f %.4f %.4f\nv %.4f %.4f %.4f\nv %.4f %.4f %.4f\nv %.4f %.4f %.4f\nf -4 -3 -2\nf -4 -2 -1\n", \
                x, y, z, x + dx / 2 - w * sin(t), y + u / 2, z + dz / 2 + w * cos(t), x + dx, y + u, z + dz, \
                x + dx / 2 + w * sin(t), y + u / 2 - 0.004, z + dz / 2 - w * cos(t)
        }
    }
}' > "$folder/spruce.obj"
printf 'newmtl bark\nKd .12 .08 .05\nnewmtl needle\nKd .08 .16 .05\n' > "$folder/spruce.mtl"

# Hills, and trees on them.
awk -v folder="$folder" 'function hill(x, z) { return 9 * sin(x / 47) * cos(z / 61) + 4 * sin(x / 23 + z / 31) + 30 * (z < -60 ? (z + 60) * (z + 60) / 90000 : 0) }
BEGIN {
    srand(2); pi = atan2(0, -1)
    ground = folder "/ground.obj"; trees = folder "/trees.csv"
    print "mtllib ground.mtl\nusemtl moss" > ground
    n = 160
    for (i = 0; i <= n; i++) for (j = 0; j <= n; j++) {
        x = -420 + 840 * j / n; z = 60 - 720 * i / n
        printf "v %.3f %.3f %.3f\n", x, hill(x, z), z > ground
    }
    for (i = 0; i < n; i++) for (j = 0; j < n; j++) {
        a = i * (n + 1) + j + 1
        print "f", a, a + 1, a + n + 2, a + n + 1 > ground
    }
    print "x,y,z,rx,ry,rz,sx,sy,sz" > trees
    while (count < 10000) {
        z = 15 - 600 * rand(); x = (2 * rand() - 1) * (60 - z) * 0.62
        # A clearing before the camera, and a path.
        if (x * x + (z - 22) * (z - 22) < 900 || (x - 6 * sin(z / 25)) ^ 2 < 12) continue
        s = 0.55 + 0.75 * rand() ^ 1.5
        printf "%.3f,%.3f,%.3f,%.2f,%.1f,%.2f,%.3f,%.3f,%.3f\n", x, hill(x, z) - 0.1, z, 5 * (rand() - 0.5), 360 * rand(), \
            5 * (rand() - 0.5), s, s * (0.85 + 0.3 * rand()), s > trees
        count++
    }
}'
printf 'newmtl moss\nKd .13 .11 .05\n' > "$folder/ground.mtl"

cat > "$folder/forest.toml" <<'TOML'
[scene]
file = "ground.obj"

[camera]
eye = [0, 16, 46]
target = [0, 9, -30]
vfov = 38

[sky]
daylight = [34, 125, 3]
daylight_model = "hosek"

[[object]]
name = "spruce"
file = "spruce.obj"

[[instance]]
of = "spruce"
table = "trees.csv"
TOML
"$halfdome" info "$folder/forest.toml"
"$halfdome" render "$folder/forest.toml" --size 800x450 --spp "${SPP:-64}" --exposure "${EXPOSURE:--3.6}" --tone neutral -o "${OUTPUT:-docs/forest.png}"
