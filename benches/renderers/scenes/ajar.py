"""Veach's test for indirect light: a room that is lit through a door left ajar alone. The lamp in the room beyond shines at its
ceiling and is seen from nowhere."""

import kit


def build(directory):
    kit.begin()
    white, wood, blue = kit.matte("white", (0.75, 0.75, 0.72)), kit.matte("wood", (0.45, 0.28, 0.15)), kit.matte("blue", (0.15, 0.25, 0.5))
    # The near room ends at y = 2; the far one at y = 5. Between them a wall with a door 1 wide and 2.1 high.
    kit.box(wood, (-2, -2, -0.1), (2, 5, 0))
    kit.box(white, (-2, -2, 2.6), (2, 5, 2.7))
    kit.box(blue, (-2.1, -2, 0), (-2, 5, 2.6))
    kit.box(white, (2, -2, 0), (2.1, 5, 2.6))
    kit.box(white, (-2, -2.1, 0), (2, -2, 2.6))
    kit.box(white, (-2, 5, 0), (2, 5.1, 2.6))
    kit.box(white, (-2, 2, 0), (-0.5, 2.1, 2.6))
    kit.box(white, (0.5, 2, 0), (2, 2.1, 2.6))
    kit.box(white, (-0.5, 2, 2.1), (0.5, 2.1, 2.6))
    # Hinged at x = -0.5, it opens by 15 degrees into the near room.
    door = kit.box(wood, (-0.5, 2, 0.01), (0.48, 2.05, 2.09))
    kit.swing(door, (-0.5, 2.05), -15)
    kit.add("plane", kit.glow("lamp", (1, 0.85, 0.6), 300), size=0.5, at=(1.2, 3.6, 1.9))
    kit.box(white, (0.9, 3.3, 1.8), (1.5, 3.9, 1.88))
    kit.box(wood, (-0.5, -0.2, 0.68), (0.9, 0.6, 0.72))
    for x in (-0.42, 0.78):
        for y in (-0.16, 0.52):
            kit.box(wood, (x, y, 0), (x + 0.05, y + 0.05, 0.68))
    kit.add("monkey", white, at=(-0.1, 0.2, 0.94), size=0.5, turn=(-20, 0, 20), smooth=True, subdivide=2)
    kit.add("uv_sphere", blue, at=(0.5, 0.1, 0.88), radius=0.16, smooth=True)
    kit.camera((-1.5, -1.8, 1.5), (0.3, 1, 0.9), 65)
    return {}
