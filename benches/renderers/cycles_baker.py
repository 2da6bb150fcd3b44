"""Bakes lightmaps with Blender's Cycles on one thread; `serve.py` says how to ask it.

Each mesh of the description has `coordinates` besides, for every vertex a place on the map from its upper left corner. A
texel of the answer has four numbers: irradiance over π, and whether something lies there.
"""

import time

import cycles_peer
import numpy as np
import serve

import bpy


def main():
    description = serve.scene()
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    cycles_peer.set_output(scene.render, description)
    cycles_peer.set_cycles(scene.cycles, description)
    width, height = description["width"], description["height"]
    image = bpy.data.images.new("lightmap", width, height, alpha=True, float_buffer=True)
    image.colorspace_settings.name = "Non-Color"
    for mesh in description["meshes"]:
        add(scene, mesh, image)
    # One object is one call of Cycles.
    bpy.ops.object.join()
    bake = scene.render.bake
    bake.use_pass_direct, bake.use_pass_indirect, bake.use_pass_color = True, True, False
    bake.margin = 0
    pixels = np.empty(4 * width * height, dtype=np.float32)

    def render(spp, seed):
        scene.cycles.samples = spp
        scene.cycles.seed = seed
        image.generated_color = (0, 0, 0, 0)
        start = time.perf_counter()
        bpy.ops.object.bake(type="DIFFUSE", use_clear=True)
        seconds = time.perf_counter() - start
        image.pixels.foreach_get(pixels)
        # Blender's first row is the lowest.
        return pixels.reshape(height, width, 4)[::-1], seconds

    serve.serve(f"Blender {bpy.app.version_string}, Cycles", render)


def add(scene, description, image):
    """Adds a mesh with its coordinates, which bakes into the image."""
    mesh = cycles_peer.load_mesh(description)
    coordinates = mesh.uv_layers.new(name="lightmap")
    for loop in mesh.loops:
        u, v = description["coordinates"][loop.vertex_index]
        coordinates.data[loop.index].uv = (u, 1 - v)
    nodes = mesh.materials[0].node_tree.nodes
    nodes.active = nodes.new("ShaderNodeTexImage")
    nodes.active.image = image
    placed = cycles_peer.add(scene, description["name"], mesh)
    placed.select_set(True)
    bpy.context.view_layer.objects.active = placed


main()
