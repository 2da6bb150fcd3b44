"""A dining room as one makes it in Blender: boards with a normal map, brass, glass, a window with a pane, and a bulb in a shade that glows."""

import kit
import numpy as np


def build(directory):
    kit.begin()
    side = 512
    y, x = np.mgrid[0:side, 0:side] / side
    plank = np.floor(8 * x)
    tint = np.random.default_rng(9).uniform(0.6, 1, 8)[plank.astype(int)]
    grain = 0.9 + 0.1 * np.sin(60 * x + 8 * np.sin(9 * y + plank))
    gap = ((8 * x) % 1 < 0.04) | ((2 * y + 0.37 * plank) % 1 < 0.01)
    color = np.where(gap[..., None], 0.08, np.array([0.55, 0.36, 0.2]) * (tint * grain)[..., None])
    relief = kit.bumps(np.where(gap, 0, 1) + 0.03 * grain, 1)
    boards = kit.material(
        "boards",
        roughness=0.4,
        picture=kit.image(directory, "boards", color),
        normals=kit.image(directory, "board normals", relief, data=True),
    )
    wall, ceiling = kit.material("wall", (0.8, 0.78, 0.74), 0.9), kit.material("ceiling", (0.9, 0.9, 0.9), 0.9)
    wood, cushion = kit.material("wood", (0.35, 0.18, 0.08), 0.35), kit.material("cushion", (0.6, 0.05, 0.04), 0.8)
    brass = kit.material("brass", (0.9, 0.65, 0.3), 0.15, 1)
    glass = kit.material("glass", (1, 1, 1), 0, Transmission_Weight=1, IOR=1.45)
    pane = kit.material("pane", (0.95, 1, 0.97), 0, Transmission_Weight=1, IOR=1.45)
    shade = kit.material("shade", (0.9, 0.85, 0.7), 0.8, Emission_Color=(1, 0.75, 0.45, 1), Emission_Strength=3)

    kit.room(wall, boards, ceiling, 5, 4, 2.6)
    kit.wall_with_window(wall, -2.5, 4, 2.6, (-0.9, 0.9, 0.9, 2.1))
    kit.box(wall, (2.5, -2.1, 0), (2.6, 2.1, 2.6))
    kit.box(pane, (-2.555, -0.9, 0.9), (-2.545, 0.9, 2.1))
    kit.box(wood, (-0.4, -0.2, 0.715), (1, 0.6, 0.765))
    for x0 in (-0.35, 0.89):
        for y0 in (-0.15, 0.49):
            kit.box(wood, (x0, y0, 0), (x0 + 0.06, y0 + 0.06, 0.715))
    for x0, y0, back in ((0.3, 1, 1), (0.1, -0.65, -1)):
        kit.box(cushion, (x0 - 0.21, y0 - 0.21, 0.425), (x0 + 0.21, y0 + 0.21, 0.475))
        kit.box(wood, (x0 - 0.21, y0 + 0.2 * back - 0.02, 0.47), (x0 + 0.21, y0 + 0.2 * back + 0.02, 0.97))
        for dx in (-0.18, 0.18):
            for dy in (-0.18, 0.18):
                kit.box(wood, (x0 + dx - 0.02, y0 + dy - 0.02, 0), (x0 + dx + 0.02, y0 + dy + 0.02, 0.425))
    kit.add("uv_sphere", brass, at=(0.75, 0.3, 0.86), radius=0.1, smooth=True)
    kit.add("cylinder", brass, at=(0.75, 0.3, 1.05), radius=0.012, depth=0.2)
    kit.add("cone", shade, at=(0.75, 0.3, 1.26), radius1=0.16, radius2=0.1, depth=0.18, end_fill_type="NOTHING", smooth=True)
    kit.lamp("POINT", (0.75, 0.3, 1.25), 12, (1, 0.8, 0.55))
    kit.add("uv_sphere", glass, at=(-0.05, 0.1, 0.866), radius=0.1, segments=48, ring_count=24, smooth=True)
    kit.lamp("SUN", (0, 0, 5), 3, (1, 0.95, 0.85), turn=(0, -55, 12))
    kit.camera((2.2, -1.75, 1.6), (-0.2, 0.4, 0.85), 68)
    return kit.sky((0.5, 0.7, 1))
