"""A room that a bright sky lights through one window, and a lamp behind a screen."""

import kit


def build(directory):
    kit.begin()
    white, wood, red = kit.matte("white", (0.75, 0.75, 0.72)), kit.matte("wood", (0.45, 0.28, 0.15)), kit.matte("red", (0.6, 0.1, 0.1))
    kit.room(white, wood, white, 5, 5, 2.6)
    kit.box(red, (-2.6, -2.6, 0), (-2.5, 2.6, 2.6))
    kit.wall_with_window(white, 2.5, 5, 2.6, (-0.8, 0.8, 0.9, 2.1))
    kit.add("monkey", white, at=(0.5, 0.8, 0.8), size=1.2, turn=(0, 0, 29), smooth=True, subdivide=2)
    kit.box(wood, (-1.5, 0.9, 0), (-0.5, 1.9, 1))
    kit.box(white, (-2.2, 1.875, 0.4), (-1.6, 1.925, 1.6), turn=-40)
    kit.add("ico_sphere", kit.glow("lamp", (1, 0.7, 0.4), 40), radius=0.08, at=(-2.2, 2.2, 1.2))
    kit.camera((-1.6, -2.2, 1.5), (0.3, 1, 0.9), 62)
    return kit.sky((0.5, 0.7, 1), 4)
