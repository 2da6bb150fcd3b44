"""What the scenes are made with: short forms of Blender's calls.

Everything is in metres, z is up, angles are in degrees, colours are linear sRGB. Materials and lights are such as glTF can
hold, so that what Cycles renders is what the exported file says: no area lights, no radii, no suns with an angle.
"""

import math
import os

import numpy as np

import bpy
from mathutils import Matrix, Vector

MESH = bpy.ops.mesh


def begin():
    """An empty scene with a black sky."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    world = bpy.context.scene.world = bpy.data.worlds.new("sky")
    sky_node().inputs["Strength"].default_value = 0
    return world


def sky_node():
    return bpy.context.scene.world.node_tree.nodes["Background"]


def sky(color, strength=1):
    """A constant sky, and the options that give halfdome the same."""
    sky_node().inputs["Color"].default_value = (*color, 1)
    sky_node().inputs["Strength"].default_value = strength
    return {"sky": [strength * channel for channel in color]}


def sky_picture(directory, pixels):
    """An equirectangular picture, its first row at the zenith, which is written to `sky.exr`."""
    import OpenEXR

    path = os.path.join(directory, "sky.exr")
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    with OpenEXR.File(header, {"RGB": pixels.astype(np.float32)}) as file:
        file.write(path)
    tree = bpy.context.scene.world.node_tree
    picture = tree.nodes.new("ShaderNodeTexEnvironment")
    picture.image = bpy.data.images.load(path)
    tree.links.new(picture.outputs["Color"], sky_node().inputs["Color"])
    sky_node().inputs["Strength"].default_value = 1
    return {"picture": path}


def directions(width, height):
    """The direction of each pixel of an equirectangular picture, as Blender reads it, and the angle from the zenith."""
    row, column = np.mgrid[0:height, 0:width] + 0.5
    polar, azimuth = math.pi * row / height, 2 * math.pi * column / width
    sine = np.sin(polar)
    return np.stack([-sine * np.cos(azimuth), sine * np.sin(azimuth), np.cos(polar)], -1), polar


def clear_sky(sun, sun_radiance, radius=0.025, width=512, height=256):
    """A blue sky that pales towards the horizon, with a glow and a disc of `radius` radians around the direction `sun`, over
    brown ground."""
    direction, polar = directions(width, height)
    cosine = direction @ (np.array(sun) / np.linalg.norm(sun))
    blue = np.array([0.25, 0.4, 0.8]) * (1 - 0.5 * np.cos(polar))[..., None]
    glow = 0.3 * np.exp(-20 * (1 - cosine))[..., None]
    pixels = np.where((polar < math.pi / 2)[..., None], blue + glow, np.array([0.15, 0.13, 0.1]))
    return np.where((cosine > math.cos(radius))[..., None], np.array(sun_radiance), pixels)


def image(directory, name, pixels, data=False):
    """An 8-bit picture of red, green, blue and perhaps alpha, its first row lowest; `data` is not converted from sRGB."""
    height, width, channels = pixels.shape
    picture = bpy.data.images.new(name, width, height, alpha=channels == 4)
    if data:
        picture.colorspace_settings.name = "Non-Color"
    full = np.ones((height, width, 4), np.float32)
    full[..., :channels] = pixels
    picture.pixels.foreach_set(full.ravel())
    picture.filepath_raw, picture.file_format = os.path.join(directory, name + ".png"), "PNG"
    picture.save()
    return picture


def bumps(heights, strength):
    """The normal map of a height field that repeats."""
    across = np.roll(heights, -1, 1) - np.roll(heights, 1, 1)
    along = np.roll(heights, -1, 0) - np.roll(heights, 1, 0)
    normal = np.stack([-strength * across, -strength * along, np.ones_like(heights)], -1)
    return 0.5 + 0.5 * normal / np.linalg.norm(normal, axis=-1, keepdims=True)


def material(name, color=(0.8, 0.8, 0.8), roughness=0.5, metallic=0, picture=None, normals=None, cutout=False, **inputs):
    """Blender's Principled BSDF, with its inputs' names written with `_`."""
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    tree = made.node_tree
    shader = tree.nodes["Principled BSDF"].inputs
    shader["Base Color"].default_value = (*color, 1)
    shader["Roughness"].default_value = roughness
    shader["Metallic"].default_value = metallic
    for key, value in inputs.items():
        shader[key.replace("_", " ")].default_value = value
    if picture:
        node = tree.nodes.new("ShaderNodeTexImage")
        node.image = picture
        tree.links.new(node.outputs["Color"], shader["Base Color"])
        if cutout:
            # The exporter knows a rounded alpha as a mask.
            rounded = tree.nodes.new("ShaderNodeMath")
            rounded.operation = "ROUND"
            tree.links.new(node.outputs["Alpha"], rounded.inputs[0])
            tree.links.new(rounded.outputs[0], shader["Alpha"])
    if normals:
        node, turn = tree.nodes.new("ShaderNodeTexImage"), tree.nodes.new("ShaderNodeNormalMap")
        node.image = normals
        tree.links.new(node.outputs["Color"], turn.inputs["Color"])
        tree.links.new(turn.outputs["Normal"], shader["Normal"])
    return made


def matte(name, color=(0.8, 0.8, 0.8), **more):
    """Diffuse reflection alone."""
    return material(name, color, roughness=1, Specular_IOR_Level=0, **more)


def glow(name, color, strength):
    """A black surface that emits."""
    return matte(name, (0, 0, 0), Emission_Color=(*color, 1), Emission_Strength=strength)


def add(primitive, surface, at=(0, 0, 0), turn=(0, 0, 0), scale=(1, 1, 1), smooth=False, subdivide=0, **size):
    """A primitive by the name in `bpy.ops.mesh.primitive_…_add`, turned about x, y, then z."""
    getattr(MESH, f"primitive_{primitive}_add")(location=at, **size)
    made = bpy.context.object
    made.rotation_euler = [math.radians(angle) for angle in turn]
    made.scale = scale
    made.data.materials.append(surface)
    if subdivide:
        modifier = made.modifiers.new("subdivide", "SUBSURF")
        modifier.levels = modifier.render_levels = subdivide
    if smooth:
        bpy.ops.object.shade_smooth()
    return made


def box(surface, low, high, turn=0):
    """A box between two corners, turned about its vertical axis."""
    low, high = np.array(low), np.array(high)
    return add("cube", surface, at=(low + high) / 2, scale=high - low, turn=(0, 0, turn), size=1)


def swing(placed, hinge, degrees):
    """Turns an object about a vertical line through `hinge`."""
    x, y = hinge
    turn = Matrix.Rotation(math.radians(degrees), 4, "Z")
    bpy.context.view_layer.update()
    placed.matrix_world = Matrix.Translation((x, y, 0)) @ turn @ Matrix.Translation((-x, -y, 0)) @ placed.matrix_world


def room(wall, floor, ceiling, width, depth, height, thick=0.1):
    """Floor, ceiling, and walls at the far and near side; those at the left and right are for `wall_with_window`."""
    x, y = width / 2, depth / 2
    box(floor, (-x, -y, -thick), (x, y, 0))
    box(ceiling, (-x, -y, height), (x, y, height + thick))
    box(wall, (-x, y, 0), (x, y + thick, height))
    box(wall, (-x, -y - thick, 0), (x, -y, height))


def wall_with_window(wall, x, depth, height, window, thick=0.1):
    """A wall in the plane of y and z, outwards of `x`, with a hole `(y0, y1, z0, z1)`."""
    low, high = (x, x + thick) if x > 0 else (x - thick, x)
    y0, y1, z0, z1 = window
    y = depth / 2 + thick
    for ya, yb, za, zb in ((-y, y, 0, z0), (-y, y, z1, height), (-y, y0, z0, z1), (y1, y, z0, z1)):
        if yb > ya and zb > za:
            box(wall, (low, ya, za), (high, yb, zb))


def lamp(kind, at, power, color=(1, 1, 1), turn=(0, 0, 0), **properties):
    """A light without a size: power in watts, of a sun in W/m². It shines down before it is turned."""
    data = bpy.data.lights.new(kind.lower(), kind)
    data.energy, data.color = power, color
    if kind == "SUN":
        data.angle = 0
    else:
        data.shadow_soft_size = 0
    for key, value in properties.items():
        setattr(data, key, value)
    made = bpy.data.objects.new(data.name, data)
    made.location, made.rotation_euler = at, [math.radians(angle) for angle in turn]
    bpy.context.scene.collection.objects.link(made)
    return made


def aim(placed, target):
    """Turns a lamp or camera, which look along their negative z axis."""
    placed.rotation_euler = (Vector(target) - placed.location).to_track_quat("-Z", "Y").to_euler()


def camera(eye, target, horizontal):
    """A camera with a horizontal field of view."""
    data = bpy.data.cameras.new("camera")
    data.sensor_fit, data.angle = "HORIZONTAL", math.radians(horizontal)
    made = bpy.data.objects.new("camera", data)
    made.location = eye
    bpy.context.scene.collection.objects.link(made)
    aim(made, target)
    bpy.context.scene.camera = made


def export(path):
    """As glTF, lights in watts a steradian rather than in lumens."""
    bpy.ops.export_scene.gltf(
        filepath=path,
        export_format="GLB",
        export_cameras=True,
        export_lights=True,
        export_apply=True,
        export_import_convert_lighting_mode="COMPAT",
    )
