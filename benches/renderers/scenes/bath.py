"""A bathroom: two mirrors that face each other, glazed tiles, chrome, a pane of glass, a round frosted lamp and small spots."""

import math

import kit
import numpy as np


def build(directory):
    kit.begin()
    side = 256
    y, x = np.mgrid[0:side, 0:side]
    joint = (y % 32 < 2) | (x % 32 < 2)
    tiles = np.where(joint[..., None], 0.45, np.array([0.75, 0.82, 0.85]))
    wall = kit.material("tiles", roughness=0.12, picture=kit.image(directory, "wall tiles", tiles), normals=kit.image(directory, "tile normals", kit.bumps(np.where(joint, 0.0, 1), 0.5), data=True))
    floor = kit.material("slate", (0.12, 0.12, 0.14), 0.25)
    ceiling, white = kit.matte("ceiling", (0.85, 0.85, 0.85)), kit.material("ceramic", (0.88, 0.88, 0.86), 0.05)
    kit.room(wall, floor, ceiling, 3, 3.4, 2.4)
    for x0 in (-1.5, 1.5):
        kit.wall_with_window(wall, x0, 3.4, 2.4, (0, 0, 2.4, 2.4))
    mirror, chrome = kit.material("mirror", (0.95, 0.95, 0.95), 0, 1), kit.material("chrome", (0.75, 0.76, 0.78), 0.05, 1)
    kit.box(mirror, (-1.49, -0.6, 1.0), (-1.48, 1.2, 2.0))
    kit.box(mirror, (1.48, -0.6, 1.0), (1.49, 1.2, 2.0))
    kit.box(white, (-1.45, -0.4, 0.7), (-0.95, 1.0, 0.85))
    kit.add("torus", white, at=(-1.15, 0.3, 0.86), major_radius=0.2, minor_radius=0.04, smooth=True)
    kit.add("cylinder", chrome, at=(-1.35, 0.3, 1.0), radius=0.02, depth=0.3, smooth=True)
    kit.add("cylinder", chrome, at=(-1.27, 0.3, 1.14), turn=(0, 90, 0), radius=0.018, depth=0.16, smooth=True)
    kit.add("uv_sphere", white, at=(0.7, 1.0, 0.25), scale=(0.6, 1.1, 0.5), radius=0.6, segments=64, ring_count=32, smooth=True)
    pane = kit.material("pane", (1, 1, 1), 0, Transmission_Weight=1, IOR=1.5)
    kit.box(pane, (0.1, 0.9, 0.1), (0.11, 1.69, 2.0))
    for z0 in (0.9, 1.3, 1.7):
        kit.add("torus", chrome, at=(0.4, 1.66, z0), turn=(90, 0, 0), major_radius=0.07, minor_radius=0.012, smooth=True)
    towel = kit.material("towel", (0.5, 0.2, 0.15), 1)
    kit.box(towel, (-0.7, 1.64, 0.8), (-0.2, 1.69, 1.6))
    kit.add("uv_sphere", kit.glow("lamp", (1, 0.95, 0.85), 9), at=(0, 0, 2.3), radius=0.15, scale=(1, 1, 0.5), smooth=True, segments=48, ring_count=24)
    for number in range(3):
        spot = kit.lamp("SPOT", (-1.3, -0.3 + 0.6 * number, 2.35), 25, (1, 0.85, 0.7), spot_size=math.radians(70), spot_blend=0.4)
        kit.aim(spot, (-1.2, -0.3 + 0.6 * number, 0))
    kit.camera((0.6, -1.55, 1.5), (-0.35, 0.9, 1.05), 72)
    return {}
