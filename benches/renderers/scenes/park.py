"""A park in the sun: trees and tufts of grass of cut-out cards, a path, a bench, a blue sky."""

import math
import random

import bpy
import kit
import numpy as np

SIDE = 256


def ellipses(chance, count):
    """A cluster of leaves: 1 where one is."""
    y, x = np.mgrid[0:SIDE, 0:SIDE] / SIDE
    covered = np.zeros((SIDE, SIDE))
    for _ in range(count):
        (across, up), turn = chance.uniform(0.2, 0.8, 2), chance.uniform(0, math.pi)
        along = (x - across) * math.cos(turn) + (y - up) * math.sin(turn)
        aside = (y - up) * math.cos(turn) - (x - across) * math.sin(turn)
        covered = np.maximum(covered, (along / 0.17) ** 2 + (aside / 0.07) ** 2 < 1)
    return covered


def blades(chance, count):
    """Blades of grass that lean and taper: 1 where one is."""
    y, x = np.mgrid[0:SIDE, 0:SIDE] / SIDE
    covered = np.zeros((SIDE, SIDE))
    for root, lean in zip(chance.uniform(0.1, 0.9, count), chance.uniform(-0.13, 0.13, count)):
        covered = np.maximum(covered, np.abs(x - root - lean * y * y) < 0.034 * (1 - y))
    return covered


def cards(name, surface, places):
    """A mesh of squares, each by its middle and half of its two edges."""
    corners = [(middle - across - up, middle + across - up, middle + across + up, middle - across + up) for middle, across, up in places]
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata([tuple(corner) for card in corners for corner in card], [], [range(4 * i, 4 * i + 4) for i in range(len(places))])
    mesh.uv_layers.new(name="UVMap").data.foreach_set("uv", np.tile([0, 0, 1, 0, 1, 1, 0, 1], len(places)).astype(np.float32))
    mesh.materials.append(surface)
    return mesh


def build(directory):
    kit.begin()
    chance, dice = np.random.default_rng(5), random.Random(5)
    shade = chance.uniform(0.6, 1, (SIDE, SIDE))

    def card(name, color, covered):
        pixels = np.concatenate([np.array(color) * shade[..., None], covered[..., None]], -1)
        return kit.material(name, picture=kit.image(directory, name, pixels), cutout=True, roughness=0.7)

    bark, wood, stone = kit.matte("bark", (0.2, 0.13, 0.08)), kit.material("wood", (0.4, 0.22, 0.1), 0.4), kit.matte("stone", (0.5, 0.48, 0.45))
    kit.add("plane", kit.matte("soil", (0.12, 0.14, 0.05)), size=80)
    kit.box(stone, (-1.2, -20, 0), (1.2, 30, 0.02))
    crown = []
    for _ in range(3000):
        outwards, across, other = (vector / np.linalg.norm(vector) for vector in chance.normal(size=(3, 3)))
        up = np.cross(across, other)
        middle = np.array([0, 0, 4.2]) + outwards * chance.uniform(0.3, 1) ** (1 / 3) * np.array([1.6, 1.6, 1.9])
        size = chance.uniform(0.1, 0.2)
        crown.append((middle, size * across, size * up / np.linalg.norm(up)))
    tree = cards("tree", card("leaves", (0.35, 0.6, 0.15), ellipses(chance, 9)), crown)
    turns = chance.uniform(0, 2 * math.pi, 40)
    upright = [(np.array([*chance.uniform(-0.5, 0.5, 2), 0.15]), 0.2 * np.array([math.cos(t), math.sin(t), 0]), np.array([0, 0, 0.15])) for t in turns]
    tuft = cards("tuft", card("grass", (0.4, 0.55, 0.2), blades(chance, 14)), upright)

    def place(mesh, x, y, scale):
        placed = bpy.data.objects.new(mesh.name, mesh)
        placed.location, placed.rotation_euler, placed.scale = (x, y, 0), (0, 0, dice.uniform(0, 2 * math.pi)), (scale,) * 3
        bpy.context.scene.collection.objects.link(placed)

    for number in range(24):
        x, y, scale = (-1) ** number * dice.uniform(2.5, 12), dice.uniform(-2, 22), dice.uniform(0.8, 1.3)
        place(tree, x, y, scale)
        kit.add("cylinder", bark, at=(x, y, 1.6 * scale), radius=0.14 * scale, depth=3.2 * scale, smooth=True)
    for number in range(700):
        place(tuft, (-1) ** number * dice.uniform(1.6, 10), dice.uniform(-4, 16), dice.uniform(0.7, 1.2))
    kit.box(wood, (-1.9, 3, 0.45), (-1.45, 5, 0.5))
    for y in (3.2, 4.8):
        kit.box(stone, (-1.85, y - 0.1, 0), (-1.5, y + 0.1, 0.45))
    kit.lamp("SUN", (0, 0, 20), 3, (1, 0.95, 0.85), turn=(40, 25, 0))
    kit.camera((0.3, -5, 1.6), (-0.2, 5, 1.9), 60)
    return kit.sky((0.35, 0.5, 0.8), 0.6)
