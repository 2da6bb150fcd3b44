"""Monkeys under a picture of a sky with a small, fierce sun."""

import kit


def build(directory):
    kit.begin()
    white, wood, red = kit.matte("white", (0.75, 0.75, 0.72)), kit.matte("wood", (0.45, 0.28, 0.15)), kit.matte("red", (0.6, 0.1, 0.1))
    kit.add("plane", white, size=14)
    for number in range(9):
        at = (-3 + 3 * (number % 3), -2 + 2.4 * (number // 3), 0.95)
        kit.add("monkey", (white, red, wood)[number % 3], at=at, turn=(0, 0, 40 * number), smooth=True, subdivide=2)
    kit.camera((0.5, -8, 3.2), (0, 0, 0.6), 62)
    return kit.sky_picture(directory, kit.clear_sky((0.5, 0.3, 0.81), (9000, 8000, 6500)))
