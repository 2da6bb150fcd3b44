"""Renders with Blender's Cycles on one thread of the processor; `serve.py` says how to ask it."""

import math
import os
import tempfile
import time

import serve

import bpy
import OpenEXR
from mathutils import Matrix, Vector

PATTERN = "SOBOL_BURLEY"
# The most that Blender takes: roulette ends paths long before.
MAX_BOUNCES = 1024


def main():
    description = serve.scene()
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    set_output(scene.render, description)
    set_cycles(scene.cycles, description)
    scene.camera = add(scene, "camera", load_camera(description))
    scene.camera.matrix_world = pose(description)
    for mesh in description["meshes"]:
        add(scene, mesh["name"], load_mesh(mesh))
    # Blender shows this pattern to developers alone.
    bpy.context.preferences.view.show_developer_ui = True
    bpy.context.preferences.experimental.use_cycles_debug = True
    scene.cycles.sampling_pattern = PATTERN
    with tempfile.TemporaryDirectory() as directory:
        serve.serve(f"Blender {bpy.app.version_string}, Cycles, {PATTERN}, light tree", renderer(scene, directory))


def renderer(scene, directory):
    """What renders `scene`, and measures the processor's time. Of that it takes what Cycles says that tracing took."""
    path = os.path.join(directory, "picture.exr")
    scene.render.filepath = path

    def render(spp, seed):
        scene.cycles.samples = spp
        scene.cycles.seed = seed
        start = time.process_time()
        bpy.ops.render.render(write_still=True)
        spent = time.process_time() - start
        with OpenEXR.File(path) as file:
            tracing, total = (seconds(file.header()[f"cycles.ViewLayer.{part}_time"]) for part in ("render", "total"))
            return file.channels()["RGB"].pixels, spent * tracing / total

    return render


def seconds(time):
    """Of the time as Cycles writes it: 01:02:03.45, or without hours."""
    total = 0.0
    for part in time.split(":"):
        total = 60 * total + float(part)
    return total


def set_output(render, description):
    """Linear floats, from one thread. Nothing persists, or Cycles would keep the first picture's seed and samples."""
    render.engine = "CYCLES"
    render.resolution_x = description["width"]
    render.resolution_y = description["height"]
    render.resolution_percentage = 100
    render.threads_mode = "FIXED"
    render.threads = 1
    render.use_persistent_data = False
    render.use_compositing = False
    render.use_sequencer = False
    render.image_settings.file_format = "OPEN_EXR"
    render.image_settings.color_mode = "RGB"
    render.image_settings.color_depth = "32"
    render.image_settings.exr_codec = "NONE"


def set_cycles(cycles, description):
    """No clamping, no denoising, no adaptive samples: a pixel is the plain mean of its samples."""
    cycles.device = "CPU"
    cycles.use_adaptive_sampling = False
    cycles.use_denoising = False
    cycles.use_auto_tile = False
    cycles.time_limit = 0
    cycles.pixel_filter_type = "BOX"
    cycles.use_light_tree = True
    cycles.light_sampling_threshold = 0
    cycles.sample_clamp_direct = 0
    cycles.sample_clamp_indirect = 0
    cycles.blur_glossy = 0
    cycles.max_bounces = MAX_BOUNCES
    cycles.diffuse_bounces = cycles.glossy_bounces = MAX_BOUNCES
    cycles.transmission_bounces = cycles.transparent_max_bounces = MAX_BOUNCES
    # Cycles counts from the second bounce on, and asks before it shades a surface, not after.
    cycles.min_light_bounces = max(description["sure_bounces"] - 1, 0)

def add(scene, name, data):
    placed = bpy.data.objects.new(name, data)
    scene.collection.objects.link(placed)
    return placed


def load_camera(description):
    camera = bpy.data.cameras.new("camera")
    camera.sensor_fit = "VERTICAL"
    camera.angle_y = math.radians(description["vfov"])
    camera.clip_start = 1e-3
    camera.clip_end = 1e3
    return camera


def pose(description):
    """A camera looks along its negative z axis."""
    eye, target, up = (Vector(description[name]) for name in ("eye", "target", "up"))
    back = (eye - target).normalized()
    right = up.cross(back).normalized()
    axes = Matrix((right, back.cross(right), back)).transposed()
    return Matrix.Translation(eye) @ axes.to_4x4()


def load_mesh(description):
    mesh = bpy.data.meshes.new(description["name"])
    mesh.from_pydata(description["positions"], [], description["triangles"])
    mesh.materials.append(load_material(description))
    return mesh


def load_material(description):
    """Diffuse reflection on both sides, light from the front."""
    material = bpy.data.materials.new(description["name"])
    nodes, link = material.node_tree.nodes, material.node_tree.links.new
    nodes.clear()
    surface = nodes.new("ShaderNodeBsdfDiffuse").outputs["BSDF"]
    surface.node.inputs["Color"].default_value = (*description["diffuse"], 1)
    if any(description["emission"]):
        material.cycles.emission_sampling = "FRONT"
        front = nodes.new("ShaderNodeMath")
        front.operation = "SUBTRACT"
        front.inputs[0].default_value = 1
        link(nodes.new("ShaderNodeNewGeometry").outputs["Backfacing"], front.inputs[1])
        emission = nodes.new("ShaderNodeEmission")
        emission.inputs["Color"].default_value = (*description["emission"], 1)
        link(front.outputs["Value"], emission.inputs["Strength"])
        both = nodes.new("ShaderNodeAddShader")
        link(surface, both.inputs[0])
        link(emission.outputs["Emission"], both.inputs[1])
        surface = both.outputs["Shader"]
    link(surface, nodes.new("ShaderNodeOutputMaterial").inputs["Surface"])
    return material


if __name__ == "__main__":
    main()
