"""A product table: soft boxes, car paint, brushed and rough metal, frosted glass, velvet, a soap film, on a bent backdrop."""

import math

import kit
import numpy as np


def build(directory):
    kit.begin()
    sky = kit.sky((1, 1, 1), 0.05)
    paper = kit.matte("paper", (0.75, 0.75, 0.75))
    bend = [(-3, 0)] + [(2 + math.sin(a), 1 - math.cos(a)) for a in np.linspace(0, math.pi / 2, 17)] + [(3, 4)]
    for (y0, z0), (y1, z1) in zip(bend, bend[1:]):
        length, turn = math.hypot(y1 - y0, z1 - z0), math.degrees(math.atan2(z1 - z0, y1 - y0))
        kit.add("plane", paper, at=(0, (y0 + y1) / 2, (z0 + z1) / 2), turn=(turn, 0, 0), scale=(10, length * 1.001, 1), size=1)
    for number, (at, strength, scale) in enumerate([((-2.6, -1, 2.6), 9, (1.2, 1.2, 1)), ((2.8, -0.5, 2), 4, (0.5, 2, 1)), ((0, 1.5, 3.4), 6, (2, 0.6, 1))]):
        kit.aim(kit.add("plane", kit.glow(f"box {number}", (1, 1, 1), strength), at=at, scale=scale, size=1), (0, 0.4, 0.3))
    surfaces = [
        kit.material("paint", (0.5, 0.02, 0.03), 0.45, 0.3, Coat_Weight=1, Coat_Roughness=0.02),
        kit.material("brushed", (0.8, 0.8, 0.82), 0.3, 1, Anisotropic=0.7),
        kit.material("frosted", (0.95, 0.98, 1), 0.25, Transmission_Weight=1, IOR=1.5),
        kit.material("velvet", (0.1, 0.02, 0.15), 0.9, Sheen_Weight=1, Sheen_Roughness=0.4, Sheen_Tint=(0.8, 0.6, 0.9, 1)),
        kit.material("copper", (0.95, 0.6, 0.45), 0.15, 1),
        kit.material("clear", (1, 1, 1), 0, Transmission_Weight=1, IOR=1.5),
        kit.material("plastic", (0.05, 0.3, 0.1), 0.25),
        kit.material("chalk", (0.8, 0.75, 0.3), 1),
    ]
    for number, surface in enumerate(surfaces):
        x0, y0 = -1.35 + 0.9 * (number % 4), -0.2 + 1.0 * (number // 4)
        if number % 3 == 2:
            kit.add("uv_sphere", surface, at=(x0, y0, 0.36), radius=0.36, segments=96, ring_count=48, smooth=True)
        else:
            kit.add("monkey", surface, at=(x0, y0, 0.36), turn=(-35, 0, 15 * number - 40), size=0.75, smooth=True, subdivide=2)
    kit.camera((0.3, -3.6, 1.7), (0, 0.4, 0.4), 42)
    return sky
