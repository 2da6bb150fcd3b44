"""An underground station: fluorescent tubes, strips of light along the platform, tiles, a polished floor, a train with panes."""

import kit
import numpy as np

LENGTH = 24


def build(directory):
    kit.begin()
    side = 128
    y, x = np.mgrid[0:side, 0:side]
    relief = np.minimum(np.minimum(x % 32, 31 - x % 32), np.minimum(y % 16, 15 - y % 16)).clip(0, 3) / 3
    glaze = np.where(relief < 0.3, 0.35, 0.75) * np.random.default_rng(2).uniform(0.92, 1, (side, side))
    picture = kit.image(directory, "tiles", glaze[..., None] * np.array([0.9, 1, 0.95]))
    tiles = kit.material("tiles", picture=picture, normals=kit.image(directory, "relief", kit.bumps(relief, 1.2), data=True), roughness=0.15)
    floor, ceiling, dark = kit.material("floor", (0.25, 0.25, 0.27), 0.12), kit.matte("ceiling", (0.7, 0.7, 0.68)), kit.matte("dark", (0.05, 0.05, 0.05))
    steel, seats = kit.material("steel", (0.65, 0.65, 0.67), 0.25, 1), kit.material("seats", (0.7, 0.15, 0.1), 0.5)
    paint = kit.material("paint", (0.1, 0.25, 0.5), 0.3, Coat_Weight=1, Coat_Roughness=0.05)
    pane = kit.material("pane", (1, 1, 1), 0, Transmission_Weight=1, IOR=1.5)
    tube, warm, sign = kit.glow("tube", (0.95, 1, 0.97), 12), kit.glow("warm", (1, 0.85, 0.6), 8), kit.glow("sign", (0.2, 0.6, 1), 3)

    kit.box(floor, (-3, -4, -0.1), (2, LENGTH, 0))
    kit.box(dark, (2, -4, -1.3), (6, LENGTH, -1.2))
    kit.box(dark, (1.95, -4, -1.2), (2, LENGTH, 0))
    kit.box(ceiling, (-3, -4, 3.2), (6, LENGTH, 3.3))
    kit.box(tiles, (-3.1, -4, 0), (-3, LENGTH, 3.2))
    kit.box(tiles, (6, -4, -1.2), (6.1, LENGTH, 3.2))
    for end in (-4.1, LENGTH):
        kit.box(dark, (-3.1, end, -1.2), (6.1, end + 0.1, 3.2))
    for number in range(12):
        for across in (-1.8, 0.6):
            kit.add("cylinder", tube, at=(across, -3 + 2.2 * number, 3.05), turn=(90, 0, 0), radius=0.02, depth=1.2, vertices=12, smooth=True)
    for number in range(7):
        kit.add("cylinder", steel, at=(-0.6, -1 + 3.4 * number, 1.6), radius=0.18, depth=3.2, vertices=48, smooth=True)
    kit.box(warm, (1.8, -3.5, 0.01), (1.83, LENGTH - 0.5, 0.02))
    kit.box(warm, (-2.98, -3.5, 0.1), (-2.96, LENGTH - 0.5, 0.13))
    for car in (4, 13):
        end = car + 8.6
        kit.box(paint, (2.15, car, -0.9), (2.2, end, 0.9))
        kit.box(paint, (2.15, car, 1.9), (2.2, end, 2.5))
        kit.box(paint, (2.2, car, 2.45), (4.8, end, 2.5))
        kit.box(seats, (4.7, car, -0.9), (4.8, end, 2.5))
        kit.box(dark, (2.2, car, -0.1), (4.8, end, -0.05))
        for window in range(4):
            near = car + 0.3 + 2.1 * window
            kit.box(pane, (2.16, near, 0.9), (2.18, near + 1.8, 1.9))
            kit.box(paint, (2.15, near + 1.8, 0.9), (2.2, near + 2.1, 1.9))
        kit.box(warm, (3.4, car + 0.3, 2.4), (3.6, end - 0.3, 2.44))
        for row in range(5):
            kit.box(seats, (3.9, car + 0.6 + 1.6 * row, 0.35), (4.5, car + 1.6 + 1.6 * row, 0.45))
    for number in range(3):
        kit.box(sign, (-2.98, 2 + 5 * number, 2), (-2.95, 4 + 5 * number, 2.4))
        kit.box(seats, (-2.7, 1 + 5 * number, 0.4), (-2.3, 3 + 5 * number, 0.48))
        kit.box(steel, (-2.6, 1.3 + 5 * number, 0), (-2.4, 1.4 + 5 * number, 0.4))
    kit.camera((-1.2, -3.2, 1.6), (0.9, 8, 1.2), 65)
    return {}
