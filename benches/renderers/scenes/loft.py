"""A loft with windows in two walls, a picture of a sky whose sun shines in, and dim panels under the ceiling."""

import kit
import numpy as np


def build(directory):
    kit.begin()
    white, steel, red = kit.matte("white", (0.8, 0.78, 0.74)), kit.matte("steel", (0.25, 0.27, 0.3)), kit.matte("red", (0.55, 0.12, 0.08))
    side = 256
    y, x = np.mgrid[0:side, 0:side] / side
    plank = np.floor(8 * x)
    tint = np.random.default_rng(2).uniform(0.6, 1, 8)[plank.astype(int)] * (0.9 + 0.1 * np.sin(60 * x + 8 * np.sin(9 * y + plank)))
    boards = kit.image(directory, "boards", np.array([0.66, 0.5, 0.34]) * tint[..., None])
    kit.room(white, kit.matte("boards", picture=boards), white, 10, 7, 3.4)
    kit.wall_with_window(white, 5, 7, 3.4, (-2.6, 0.4, 0.8, 2.7))
    kit.wall_with_window(white, -5, 7, 3.4, (0.6, 2.4, 1, 2.6))
    for y0 in (-1.6, -0.6):
        kit.box(steel, (4.98, y0 - 0.03, 0.8), (5.05, y0 + 0.03, 2.7))
    for x0 in (-2, 2):
        kit.add("cylinder", steel, at=(x0, 1, 1.7), radius=0.14, depth=3.4, smooth=True)
    panel = kit.glow("panel", (1, 0.9, 0.75), 4)
    for number in range(4):
        kit.add("plane", panel, at=(-3.6 + 2.4 * number, -0.5, 3.3), turn=(180, 0, 0), scale=(1.2, 0.2, 1), size=1)
    kit.box(white, (-1.6, -0.6, 0.7), (0.8, 0.6, 0.76))
    for x0 in (-1.5, 0.64):
        kit.box(steel, (x0, -0.5, 0), (x0 + 0.06, 0.5, 0.7))
    kit.box(red, (2.2, 1.4, 0), (4.2, 2.4, 0.45))
    kit.box(red, (2.2, 2.4, 0), (4.2, 2.65, 0.95))
    kit.box(steel, (-4.9, -3.3, 0), (-4.3, 0.2, 1.1))
    kit.add("monkey", white, at=(-0.6, 0, 1.05), size=0.6, turn=(-15, 0, 30), smooth=True, subdivide=2)
    kit.add("torus", red, at=(0.3, 0.1, 0.86), major_radius=0.2, minor_radius=0.07, smooth=True)
    kit.add("uv_sphere", steel, at=(3.2, -1, 0.5), radius=0.5, smooth=True)
    kit.camera((-4.2, -3.1, 1.7), (1.5, 1.2, 1), 70)
    # Blender's picture of a sky has x to the right of its middle; the sun stands before the larger window.
    return kit.sky_picture(directory, kit.clear_sky((0.8, -0.25, 0.5), (9000, 7800, 6000)))
