"""A chapel: sun and sky through slits in one wall, columns, a dark nave, two candles; nearly all of it is lit indirectly."""

import math

import kit
import numpy as np


def build(directory):
    kit.begin()
    sky = kit.sky((0.5, 0.7, 1.0), 2)
    side = 256
    y, x = np.mgrid[0:side, 0:side]
    joint = (y % 64 < 3) | ((x + 64 * ((y // 64) % 2)) % 128 < 3)
    grain = np.random.default_rng(9).uniform(0.9, 1.05, (side, side))
    blocks = np.where(joint[..., None], 0.3, np.array([0.62, 0.58, 0.52]) * grain[..., None])
    stone = kit.matte("stone", picture=kit.image(directory, "blocks", blocks), normals=kit.image(directory, "block normals", kit.bumps(np.where(joint, 0, 1) + 0.1 * grain, 0.6), data=True))
    plain, wood = kit.matte("plaster", (0.65, 0.62, 0.57)), kit.material("wood", (0.25, 0.14, 0.07), 0.5)
    floor = kit.material("flags", (0.4, 0.38, 0.36), 0.35)
    kit.room(stone, floor, plain, 8, 14, 6)
    kit.wall_with_window(plain, -4, 14, 6, (0, 0, 6, 6))
    edges = [-7.2] + [edge for number in range(5) for edge in (-5.3 + 2.6 * number, -4.9 + 2.6 * number)] + [7.2]
    for low, high in zip(edges[::2], edges[1::2]):
        kit.box(plain, (4, low, 0), (4.3, high, 6))
    for number in range(5):
        kit.box(plain, (4, -5.3 + 2.6 * number, 0), (4.3, -4.9 + 2.6 * number, 2))
        kit.box(plain, (4, -5.3 + 2.6 * number, 5), (4.3, -4.9 + 2.6 * number, 6))
    for number in range(5):
        for x0 in (-2.2, 2.2):
            kit.add("cylinder", plain, at=(x0, -5 + 2.6 * number, 3), radius=0.28, depth=6, vertices=48, smooth=True)
    for number in range(6):
        for x0 in (-1.1, 1.1):
            kit.box(wood, (x0 - 0.8, -4 + 1.2 * number, 0.4), (x0 + 0.8, -3.6 + 1.2 * number, 0.45))
            kit.box(wood, (x0 - 0.8, -3.62 + 1.2 * number, 0), (x0 + 0.8, -3.57 + 1.2 * number, 0.9))
    kit.box(plain, (-1, 5, 0), (1, 5.8, 1))
    for x0 in (-0.7, 0.7):
        kit.add("cylinder", plain, at=(x0, 5.4, 1.15), radius=0.04, depth=0.3)
        kit.add("uv_sphere", kit.glow(f"flame {x0}", (1, 0.6, 0.25), 400), at=(x0, 5.4, 1.36), radius=0.02, scale=(1, 1, 2))
    kit.add("monkey", kit.material("gold", (0.9, 0.7, 0.3), 0.2, 1), at=(0, 5.4, 1.4), size=0.7, turn=(0, 0, 0), smooth=True, subdivide=2)
    kit.aim(kit.lamp("SUN", (12, -4, 14), 12, (1, 0.93, 0.8)), (0, 0, 0))
    kit.camera((-1.6, -6.6, 1.7), (0.4, 2, 1.9), 70)
    return sky
