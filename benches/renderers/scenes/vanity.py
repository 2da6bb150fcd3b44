"""A dressing room: bulbs around a mirror, a second mirror opposite, gold, lacquer and glass on a table, velvet curtains."""

import kit


def build(directory):
    kit.begin()
    wall, ceiling = kit.matte("wall", (0.6, 0.35, 0.35)), kit.matte("ceiling", (0.8, 0.78, 0.75))
    kit.room(wall, kit.material("floor", (0.25, 0.2, 0.18), 0.25), ceiling, 3, 3, 2.5)
    for x in (-1.5, 1.5):
        kit.wall_with_window(wall, x, 3, 2.5, (0, 0, 2.5, 2.5))
    mirror = kit.material("mirror", (0.95, 0.95, 0.95), 0, 1)
    kit.box(mirror, (-0.6, 1.47, 0.9), (0.6, 1.49, 1.9))
    kit.box(mirror, (-0.7, -1.49, 0.2), (0.7, -1.47, 2.1))

    bulb = kit.glow("bulb", (1, 0.85, 0.65), 25)
    places = [(x, 0.95 + 0.18 * k) for k in range(6) for x in (-0.7, 0.7)] + [(-0.6 + 0.2 * k, 2) for k in range(7)]
    for x, z in places:
        kit.add("uv_sphere", bulb, at=(x, 1.43, z), radius=0.035, segments=16, ring_count=8, smooth=True)

    kit.box(kit.material("table", (0.85, 0.85, 0.83), 0.15), (-0.8, 0.95, 0.72), (0.8, 1.47, 0.76))
    pots = [
        kit.material("gold", (0.95, 0.7, 0.35), 0.15, 1),
        kit.material("lacquer", (0.6, 0.03, 0.08), 0.1, Coat_Weight=1),
        kit.material("jar", (1, 1, 1), 0, Transmission_Weight=1, IOR=1.5),
    ]
    for number, x in enumerate((-0.5, -0.35, 0.3, 0.45, 0.55)):
        pot = pots[number % len(pots)]
        kit.add("cylinder", pot, at=(x, 1.2, 0.82), radius=0.03, depth=0.12, vertices=48, smooth=True)
    head = kit.material("head", (0.65, 0.42, 0.32), 0.45)
    gown = kit.material("gown", (0.1, 0.15, 0.4), 0.7, Sheen_Weight=0.5)
    kit.add("uv_sphere", head, at=(0.05, 0.3, 1.3), scale=(0.1, 0.12, 0.14), radius=1, smooth=True)
    kit.add("cone", gown, at=(0.05, 0.3, 0.6), radius1=0.4, radius2=0.12, depth=1.2, smooth=True)
    curtain = kit.matte("curtain", (0.4, 0.05, 0.08))
    for k in range(14):
        kit.add("cylinder", curtain, at=(1.4, -1.3 + 0.19 * k, 1.2), radius=0.08, depth=2.4, smooth=True)
    kit.camera((-0.9, -1.1, 1.6), (0.2, 1.4, 1.25), 70)
    return {}
