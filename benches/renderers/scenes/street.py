"""A street at night: 36 street lamps as spots, 24 lanterns as points, bulbs over doors, lit windows, and a moon like a weak sun."""

import math
import random

import kit
import numpy as np


def build(directory):
    kit.begin()
    chance = random.Random(3)
    side = 128
    noise = np.random.default_rng(7).uniform(0.7, 1.1, (side, side))
    y, x = np.mgrid[0:side, 0:side]
    asphalt = kit.image(directory, "asphalt", np.stack([0.28 * noise, 0.28 * noise, 0.3 * noise], -1))
    mortar = (y % 16 < 2) | ((x + 16 * ((y // 16) % 2)) % 32 < 2)
    brick = np.where(mortar[..., None], 0.6, np.array([0.62, 0.32, 0.24]) * noise[..., None])
    road, facade = kit.matte("road", picture=asphalt), kit.matte("facade", picture=kit.image(directory, "brick", brick))
    pole, leaves, paint = kit.matte("pole", (0.1, 0.1, 0.12)), kit.matte("leaves", (0.1, 0.3, 0.08)), kit.matte("paint", (0.5, 0.1, 0.1))
    lit = [kit.glow(f"window {number}", (1, 0.75, 0.45), 0.3 * 4**number) for number in range(3)]

    kit.add("plane", road, size=120)
    for row in (-1, 1):
        for number in range(10):
            depth, height = -8 + 9 * number, chance.uniform(5, 12)
            near, far = sorted((row * 7, row * 14))
            kit.box(facade, (near, depth, 0), (far, depth + 8, height))
            for floor in range(int(height / 3)):
                for column in range(3):
                    if chance.random() < 0.4:
                        at = (row * 6.98, depth + 1.6 + 2.4 * column, 1.8 + 3 * floor)
                        kit.add("plane", chance.choice(lit), at=at, turn=(0, -90 * row, 0), scale=(1.2, 0.9, 1), size=1)
            bulb = kit.glow(f"bulb {row} {number}", (1, 0.9, 0.7), 10 ** chance.uniform(1, 3))
            kit.add("ico_sphere", bulb, at=(row * 6.8, depth + 4.2, 2.6), radius=0.05, subdivisions=1)
        spot = {"spot_size": math.radians(110), "spot_blend": 0.02}
        for number in range(18):
            at = np.array([row * 4.2, -7 + 5 * number, 5])
            kit.add("cylinder", pole, at=(row * 4.9, at[1], 2.5), radius=0.06, depth=5)
            kit.box(pole, (min(row * 4, row * 5), at[1] - 0.05, 5.05), (max(row * 4, row * 5), at[1] + 0.05, 5.12))
            color = [(1, 0.7, 0.35), (1, 0.95, 0.9), (1, 0.85, 0.6)][number % 3]
            kit.lamp("SPOT", at, 10 ** chance.uniform(2, 3), color, **spot)
        for number in range(12):
            at = (row * 6.3, -6 + 7.3 * number, 2.2)
            kit.lamp("POINT", at, chance.uniform(3, 40), (1, 0.6, 0.3))
        for number in range(8):
            at = (row * 5.6, -4.5 + 10 * number, 2.4)
            kit.add("ico_sphere", leaves, at=at, radius=0.9, subdivisions=4, smooth=True)
            kit.add("cylinder", pole, at=(at[0], at[1], 0.8), radius=0.1, depth=1.6)
    kit.box(paint, (1, 1, 0.3), (2.8, 5, 0.9))
    kit.box(paint, (1.2, 1.8, 0.9), (2.6, 4, 1.5))
    kit.add("monkey", leaves, at=(-1.5, 2, 0.95), turn=(0, 0, 10), smooth=True, subdivide=2)
    kit.lamp("SUN", (0, 0, 20), 0.02, (0.6, 0.75, 1), turn=(35, 20, 0))
    kit.camera((-0.5, -7, 2.2), (0.3, 6, 1.9), 62)
    return kit.sky((0.3, 0.45, 1), 0.01)
