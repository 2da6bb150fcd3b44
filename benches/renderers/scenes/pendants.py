"""A dining room at night: three globes of glass around bulbs, the left one clear, the others frosted, over a varnished table."""

import kit


def build(directory):
    kit.begin()
    wall, ceiling = kit.matte("wall", (0.6, 0.62, 0.6)), kit.matte("ceiling", (0.8, 0.8, 0.8))
    kit.room(wall, kit.material("floor", (0.35, 0.25, 0.17), 0.35), ceiling, 5, 6, 2.7)
    for x in (-2.5, 2.5):
        kit.wall_with_window(wall, x, 6, 2.7, (0, 0, 2.7, 2.7))
    brass = kit.material("brass", (0.9, 0.65, 0.3), 0.25, 1)
    for x, roughness in ((-0.9, 0), (0, 0.4), (0.9, 0.4)):
        glass = kit.material(f"glass {x}", (1, 0.98, 0.95), roughness, Transmission_Weight=1, IOR=1.45)
        globe(glass, (x, 0.4, 1.7), 0.14, 0.135)
        kit.add("uv_sphere", kit.glow(f"bulb {x}", (1, 0.78, 0.5), 180), at=(x, 0.4, 1.7), radius=0.03)
        kit.add("cylinder", brass, at=(x, 0.4, 2.27), radius=0.008, depth=0.86, smooth=True)

    wood = kit.material("wood", (0.3, 0.15, 0.07), 0.25, Coat_Weight=0.6, Coat_Roughness=0.1)
    kit.box(wood, (-1.4, -0.1, 0.72), (1.4, 0.9, 0.76))
    for x in (-1.3, 1.3):
        for y in (0, 0.8):
            kit.box(wood, (x - 0.04, y - 0.04, 0), (x + 0.04, y + 0.04, 0.72))
    china, velvet = kit.material("china", (0.85, 0.85, 0.82), 0.1), kit.matte("velvet", (0.1, 0.2, 0.15))
    for x in (-0.8, 0, 0.8):
        for y in (0.1, 0.7):
            kit.add("cylinder", china, at=(x, y, 0.77), radius=0.13, depth=0.015, smooth=True)
        kit.box(velvet, (x - 0.22, -0.55, 0.42), (x + 0.22, -0.15, 0.5))
        kit.box(velvet, (x - 0.22, 1, 0.42), (x + 0.22, 1.4, 0.5))
        kit.box(velvet, (x - 0.22, 1.36, 0.5), (x + 0.22, 1.42, 1))
    kit.camera((1.6, -2.6, 1.6), (-0.1, 0.5, 1), 65)
    return {}


def globe(glass, at, radius, hollow):
    """A ball with a hollow, whose front faces its middle."""
    kit.add("uv_sphere", glass, at=at, radius=radius, segments=48, ring_count=24, smooth=True)
    inside = kit.add("uv_sphere", glass, at=at, radius=hollow, segments=48, ring_count=24, smooth=True)
    inside.data.flip_normals()
