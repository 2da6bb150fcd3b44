"""A yard with one light of each kind: sun, point, spot, an emissive panel and a constant sky; a picture on the ground, a
cut-out, smooth and mirrored meshes. The spot lights a small region brightly."""

import math

import kit
import numpy as np


def build(directory):
    kit.begin()
    side = 256
    y, x = np.mgrid[0:side, 0:side]
    checker = ((x // 32 + y // 32) % 2).astype(float)
    tiles = np.stack([0.15 + 0.6 * checker, 0.2 + 0.5 * x / side, 0.7 - 0.5 * y / side], -1)
    hole = ((x - 128) ** 2 + (y - 128) ** 2 < 110**2) & ((x // 16) % 2 == 0)
    leaf = np.stack([0.1 + 0 * checker, 0.5 + 0.2 * checker, 0.1 + 0 * checker, hole], -1)

    kit.add("plane", kit.matte("ground", picture=kit.image(directory, "ground", tiles)), size=12)
    monkey = kit.matte("monkey", (0.7, 0.45, 0.3))
    kit.add("monkey", monkey, at=(0, 0, 1.1), turn=(-17, 0, 23), smooth=True, subdivide=2)
    kit.add("monkey", monkey, at=(2.4, 0.6, 0.9), turn=(0, 17, -29), scale=(-0.6, 0.6, 0.8), smooth=True, subdivide=1)
    kit.add("cube", kit.matte("block", (0.2, 0.35, 0.7)), size=1.5, at=(-2.3, 0.8, 0.75), turn=(0, 0, 29))
    ring = kit.matte("ring", (0.6, 0.6, 0.2))
    kit.add("torus", ring, at=(-1.2, -1.6, 0.35), major_radius=0.6, minor_radius=0.2)
    picture = kit.image(directory, "leaf", leaf)
    kit.add("grid", kit.matte("leaf", picture=picture, cutout=True), size=1.6, at=(1.6, -1.5, 0.8), turn=(75, 0, 34))
    kit.add("plane", kit.glow("panel", (1, 0.8, 0.5), 6), size=1.2, at=(-3, -2, 2.2), turn=(0, 126, 23))

    kit.lamp("SUN", (0, 0, 5), 1.2, (1, 0.95, 0.85), turn=(34, 17, 0))
    kit.lamp("POINT", (2.5, -2, 2), 60, (0.6, 0.8, 1))
    spot = {"spot_size": math.radians(40), "spot_blend": 0.15}
    kit.lamp("SPOT", (-1, -3, 4), 250, (1, 0.5, 0.5), turn=(40, 0, -11), **spot)
    kit.camera((0.5, -6.5, 3), (0.25, -1.9, 1.1), 52)
    return kit.sky((0.3, 0.4, 0.6))
