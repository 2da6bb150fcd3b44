"""A lounge at night: a bright screen with a picture, lamps under open shades, a mirror, a glass table, cut-out leaves."""

import math

import kit
import numpy as np


def build(directory):
    kit.begin()
    wall, ceiling = kit.matte("wall", (0.7, 0.66, 0.6)), kit.matte("ceiling", (0.8, 0.8, 0.8))
    side = 256
    y, x = np.mgrid[0:side, 0:side]
    grain = 0.5 + 0.5 * np.sin(0.15 * y + 2 * np.sin(0.02 * x) + 8 * (x // 64))
    boards = np.where((x % 64 < 1)[..., None], 0.1, np.array([0.45, 0.28, 0.16]) * (0.7 + 0.3 * grain[..., None]))
    floor = kit.material("boards", roughness=0.3, picture=kit.image(directory, "boards", boards))
    kit.room(wall, floor, ceiling, 6, 5, 2.6)
    for x0 in (-3, 3):
        kit.wall_with_window(wall, x0, 5, 2.6, (0, 0, 2.6, 2.6))

    show = np.stack([0.5 + 0.5 * np.sin(0.05 * x), np.where(y > 120, 0.8, 0.2), np.where(x > 160, 0.9, 0.1)], -1)
    show[(x - 90) ** 2 + (y - 170) ** 2 < 900] = 1
    screen = kit.glow("screen", (1, 1, 1), 6)
    tree = screen.node_tree
    node = tree.nodes.new("ShaderNodeTexImage")
    node.image = kit.image(directory, "show", show)
    tree.links.new(node.outputs["Color"], tree.nodes["Principled BSDF"].inputs["Emission Color"])
    kit.add("plane", screen, at=(0.4, 2.47, 1.3), turn=(90, 0, 0), scale=(1.6, 0.9, 1), size=1)

    brass, linen = kit.material("brass", (0.9, 0.65, 0.3), 0.3, 1), kit.matte("linen", (0.75, 0.7, 0.6))
    for number, (x0, y0, z0) in enumerate([(-2.4, 1.9, 1.4), (2.4, 1.6, 1.1), (-2.5, -1.2, 1.5)]):
        kit.add("cone", linen, at=(x0, y0, z0), radius1=0.25, radius2=0.14, depth=0.3, end_fill_type="NOTHING", smooth=True)
        kit.add("uv_sphere", kit.glow(f"bulb {number}", (1, 0.75, 0.45), 260), at=(x0, y0, z0), radius=0.035)
        kit.add("cylinder", brass, at=(x0, y0, z0 / 2 - 0.1), radius=0.015, depth=z0 - 0.2, smooth=True)
    mirror = kit.material("mirror", (0.95, 0.95, 0.95), 0, 1)
    kit.box(mirror, (-2.98, -0.6, 0.6), (-2.96, 0.8, 2.1))
    glass = kit.material("glass", (0.95, 1, 0.97), 0, Transmission_Weight=1, IOR=1.5)
    kit.box(glass, (-0.8, -0.3, 0.45), (0.8, 0.5, 0.48))
    for x0, y0 in ((-0.7, -0.2), (0.7, -0.2), (-0.7, 0.4), (0.7, 0.4)):
        kit.add("cylinder", brass, at=(x0, y0, 0.225), radius=0.02, depth=0.45, smooth=True)
    kit.add("monkey", kit.material("glaze", (0.1, 0.25, 0.4), 0.1), at=(0.3, 0.1, 0.68), turn=(-20, 0, 30), size=0.4, smooth=True, subdivide=2)
    kit.add("uv_sphere", glass, at=(-0.4, 0.1, 0.62), radius=0.14, segments=64, ring_count=32, smooth=True)
    leather = kit.material("leather", (0.25, 0.09, 0.05), 0.4)
    kit.box(leather, (1.2, -1.6, 0.1), (2.6, 0, 0.45))
    kit.box(leather, (2.4, -1.6, 0.45), (2.7, 0, 0.95))

    leaf = np.zeros((64, 64, 4))
    v, u = np.mgrid[0:64, 0:64] / 63 - 0.5
    inside = np.abs(u) < 0.35 * np.sqrt(np.maximum(0, 0.25 - v * v)) * 2
    leaf[..., :3] = np.array([0.12, 0.35, 0.08]) + 0.15 * (np.abs(u) < 0.02)[..., None]
    leaf[..., 3] = inside
    green = kit.matte("leaf", picture=kit.image(directory, "leaf", leaf), cutout=True)
    dice = np.random.default_rng(3)
    for number in range(60):
        turn = dice.uniform(0, 360)
        at = (-1.7 + 0.25 * math.cos(turn), 1.7 + 0.25 * math.sin(turn), dice.uniform(0.6, 1.6))
        kit.add("plane", green, at=at, turn=(dice.uniform(20, 80), 0, turn), size=0.35)
    kit.add("cylinder", kit.material("pot", (0.5, 0.25, 0.15), 0.6), at=(-1.7, 1.7, 0.25), radius=0.2, depth=0.5, smooth=False)
    kit.camera((1.7, -2.35, 1.5), (-0.5, 0.9, 0.85), 70)
    return {}
