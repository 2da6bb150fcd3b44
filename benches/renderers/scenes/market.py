"""A market at night: strings of 1,600 small bulbs, 60 lanterns as points, stalls of cloth, crates, a crowd of heads."""

import math

import kit
import numpy as np

import bpy


def build(directory):
    kit.begin()
    sky = kit.sky((0.2, 0.25, 0.5), 0.02)
    dice = np.random.default_rng(11)
    kit.add("plane", kit.material("wet", (0.12, 0.12, 0.13), 0.2), size=60)
    cloths = [kit.matte(f"cloth {n}", tuple(dice.uniform(0.1, 0.8, 3))) for n in range(6)]
    wood = kit.material("wood", (0.35, 0.2, 0.1), 0.6)
    bulbs = [kit.glow(f"bulb {n}", c, s) for n, (c, s) in enumerate([((1, 0.7, 0.4), 120), ((1, 0.3, 0.2), 60), ((0.4, 0.6, 1), 90)])]
    meshes = []
    for bulb in bulbs:
        first = kit.add("ico_sphere", bulb, at=(0, 0, -5), radius=0.02, subdivisions=2)
        meshes.append(first.data)
    collection = bpy.context.scene.collection

    def copy(mesh, at, turn=0, scale=1):
        made = bpy.data.objects.new(mesh.name, mesh)
        made.location, made.rotation_euler, made.scale = at, (0, 0, turn), (scale, scale, scale)
        collection.objects.link(made)

    for row in range(40):
        y0 = -4 + 0.8 * row
        for number in range(40):
            s = number / 39
            copy(meshes[row % 3], (-5 + 10 * s, y0 + 0.1 * math.sin(7 * s), 3.6 - 2 * s * (1 - s)))
    head = kit.add("monkey", kit.material("skin", (0.55, 0.4, 0.3), 0.5), at=(0, 0, -5), size=0.45, smooth=True, subdivide=1)
    for number in range(120):
        copy(head.data, (dice.uniform(-2, 2), dice.uniform(-2, 24), dice.uniform(1.3, 1.7)), dice.uniform(0, 6.3))
    for number in range(16):
        x0, y0 = (-3.6 if number % 2 else 3.6), 1.8 * number - 2
        kit.box(wood, (x0 - 1, y0, 0), (x0 + 1, y0 + 1.4, 0.9))
        kit.add("plane", cloths[number % 6], at=(x0, y0 + 0.6, 2.3), turn=(0, 15 if x0 > 0 else -15, 0), scale=(2.4, 1.8, 1), size=1)
        for apple in range(24):
            kit.add("uv_sphere", cloths[(number + apple) % 6], at=(x0 - 0.8 + 0.2 * (apple % 8), y0 + 0.2 + 0.25 * (apple // 8), 0.98), radius=0.09, segments=16, ring_count=8, smooth=True)
    for number in range(60):
        kit.lamp("POINT", (dice.uniform(-4, 4), dice.uniform(-3, 26), dice.uniform(2, 2.6)), dice.uniform(2, 40), (1, 0.6, 0.3))
    kit.camera((0.3, -3.6, 1.9), (0, 6, 1.6), 65)
    return sky
