"""A hall with 240 small bulbs whose powers differ by a factor of 300, columns, and smooth monkeys."""

import random

import kit


def build(directory):
    kit.begin()
    white, wood, red = kit.matte("white", (0.75, 0.75, 0.72)), kit.matte("wood", (0.45, 0.28, 0.15)), kit.matte("red", (0.6, 0.1, 0.1))
    kit.room(white, wood, white, 20, 20, 4)
    for x in (-10, 10):
        kit.wall_with_window(white, x, 20, 4, (0, 0, 4, 4))
    for number in range(12):
        at = (-8 + 5 * (number % 4), -6 + 6 * (number // 4), 2)
        kit.add("cylinder", red, radius=0.3, depth=4, at=at)
    for number in range(4):
        kit.add("monkey", white, at=(-6 + 4 * number, -3, 1), smooth=True, subdivide=2)
    chance = random.Random(11)
    for number in range(240):
        color = [chance.uniform(low, 1) for low in (0.5, 0.5, 0.4)]
        bulb = kit.glow(f"bulb {number}", color, 10 ** chance.uniform(0, 2.5))
        at = [chance.uniform(-9.5, 9.5), chance.uniform(-9.5, 9.5), chance.uniform(0.5, 3.8)]
        kit.add("ico_sphere", bulb, radius=0.03, subdivisions=1, at=at)
    kit.camera((-1, -9.3, 1.7), (0, 0, 1.2), 62)
    return {}
