"""A shop: spots on bumpy, textured walls, a polished floor, brass and porcelain on pedestals, a strip of light."""

import math

import kit
import numpy as np


def build(directory):
    kit.begin()
    side = 256
    y, x = np.mgrid[0:side, 0:side]
    joint = (y % 32 < 2) | ((x + 32 * ((y // 32) % 2)) % 64 < 2)
    grain = np.random.default_rng(5).uniform(0.85, 1.05, (side, side))
    stone = np.where(joint[..., None], 0.35, np.array([0.72, 0.66, 0.58]) * grain[..., None])
    relief = kit.image(directory, "stone normals", kit.bumps(np.where(joint, 0, 1) + 0.05 * grain, 0.8), data=True)
    wall = kit.material("stone", roughness=0.7, picture=kit.image(directory, "stone", stone), normals=relief)
    tiles = ((x // 64 + y // 64) % 2)[..., None] * np.array([0.5, 0.48, 0.45]) + 0.12
    floor = kit.material("polished", roughness=0.15, picture=kit.image(directory, "tiles", tiles))
    ceiling, white = kit.matte("ceiling", (0.6, 0.6, 0.6)), kit.material("porcelain", (0.85, 0.85, 0.82), 0.08)
    brass, cloth = kit.material("brass", (0.9, 0.65, 0.3), 0.25, 1), kit.matte("cloth", (0.15, 0.25, 0.5))
    stand = kit.material("stand", (0.3, 0.3, 0.32), 0.4)

    kit.room(wall, floor, ceiling, 8, 6, 3)
    for x0 in (-4, 4):
        kit.wall_with_window(wall, x0, 6, 3, (0, 0, 3, 3))
    things = [("monkey", brass, {"size": 0.7}), ("uv_sphere", white, {"radius": 0.33}), ("torus", cloth, {"major_radius": 0.3, "minor_radius": 0.12}), ("monkey", white, {"size": 0.7}), ("cone", brass, {"radius1": 0.3, "depth": 0.7}), ("uv_sphere", cloth, {"radius": 0.33})]
    for number, (shape, surface, size) in enumerate(things):
        x0, y0 = -2.4 + 2.4 * (number % 3), 0.2 + 1.6 * (number // 3)
        kit.box(stand, (x0 - 0.3, y0 - 0.3, 0), (x0 + 0.3, y0 + 0.3, 0.8))
        smooth = shape != "cone"
        kit.add(shape, surface, at=(x0, y0, 1.16), turn=(0, 0, 25 * number), smooth=smooth, subdivide=2 if shape == "monkey" else 0, **size)
    for shelf in range(3):
        kit.box(stand, (-3.95, -2, 0.6 + 0.6 * shelf), (-3.6, 2.5, 0.64 + 0.6 * shelf))
        for number in range(9):
            kit.add("cylinder", (white, brass, cloth)[(number + shelf) % 3], at=(-3.78, -1.8 + 0.5 * number, 0.79 + 0.6 * shelf), radius=0.1, depth=0.3, smooth=False)
    spot = {"spot_size": math.radians(38), "spot_blend": 0.02}
    for number in range(8):
        x0 = -3.5 + number
        kit.aim(kit.lamp("SPOT", (x0, 1.2, 2.9), 60 if number % 2 else 25, (1, 0.85, 0.65), **spot), (x0, 3, 1.5))
    for number in range(6):
        x0, y0 = -2.4 + 2.4 * (number % 3), 0.2 + 1.6 * (number // 3)
        kit.aim(kit.lamp("SPOT", (x0 + 0.6, y0 - 0.9, 2.9), 40, (1, 0.95, 0.9), **spot), (x0, y0, 1.1))
    kit.add("plane", kit.glow("strip", (0.8, 0.9, 1), 12), at=(0, -1.6, 2.95), turn=(180, 0, 0), scale=(4, 0.12, 1), size=1)
    kit.camera((1.6, -2.8, 1.6), (-0.5, 1.2, 1.05), 65)
    return {}
