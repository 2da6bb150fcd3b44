"""Opens our Cryptomatte layers with Blender's compositor, and compares the mattes with those that Cycles renders.

usage, after setup-renderers.sh and `cargo build --release`:
    target/renderers/bin/python benches/renderers/cryptomatte.py [--halfdome FILE] [--size WxH] [--spp N] [SCENE...]

Each scene is made in Blender. Blender's Cryptomatte node reads the layer `CryptoObject` of our EXR and makes the matte of
each object by its name, and so by the manifest and the hash. Printed are the largest difference of a pixel between these
mattes and the sums of the coverages in the file, and of a matte's mean from that of the layer that Cycles renders. The exit
code is 1 if a pixel differs by more than 1e-3, or a mean by more than 0.2% of the picture; the objects are named.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile

import cycles_peer
import cycles_scenes
import numpy as np
import serve

import bpy
import OpenEXR

ROOT = os.path.join(os.path.dirname(__file__), "..", "..")
SAME, NEAR = 1e-3, 2e-3


def channels(path):
    """The channels of all parts by name, and the first header."""
    with OpenEXR.File(path, separate_channels=True) as file:
        header = dict(file.header())
        return {name: channel.pixels for part in file.parts for name, channel in part.channels.items()}, header


def coverage(found, layer, number):
    """The sum of what covers pixels under an id, by the layout of Cryptomatte 1.2."""
    total = 0
    for level in range(99):
        # Blender writes these names in small letters.
        spelled = str.lower if f"{layer}{level:02}.r" in found else str.upper
        for name, cover in ("rg", "ba"):
            channel, weight = (f"{layer}{level:02}.{spelled(part)}" for part in (name, cover))
            if channel not in found:
                return total
            total = total + np.where(found[channel].view(np.uint32) == number, found[weight], 0)
    return total


def manifest(header):
    """The names of objects with their ids."""
    key = next(key for key, value in header.items() if key.endswith("/name") and value == "CryptoObject")
    return {name: int(number, 16) for name, number in json.loads(header[key[:-4] + "manifest"]).items()}


def matte(picture, layer, name, folder):
    """What Blender's node makes of our file."""
    scene = bpy.context.scene
    tree = scene.compositing_node_group = bpy.data.node_groups.new("compositor", "CompositorNodeTree")
    node = tree.nodes.new("CompositorNodeCryptomatteV2")
    node.source, node.image = "IMAGE", picture
    node.layer_name, node.matte_id = layer, name
    tree.interface.new_socket(name="Image", in_out="OUTPUT", socket_type="NodeSocketColor")
    tree.links.new(node.outputs["Matte"], tree.nodes.new("NodeGroupOutput").inputs["Image"])
    settings = scene.render.image_settings
    settings.media_type, settings.file_format, settings.color_depth = "IMAGE", "OPEN_EXR", "32"
    scene.render.filepath = os.path.join(folder, "matte.exr")
    bpy.ops.render.render(write_still=True)
    bpy.data.node_groups.remove(tree)
    return channels(scene.render.filepath)[0]["R"]


def cycles(folder, options):
    """Cycles' own layer, of the scene that was just made."""
    scene = bpy.context.scene
    scene.cycles.samples = options.spp
    view = scene.view_layers[0]
    view.use_pass_cryptomatte_object = True
    view.update_render_passes()
    scene.render.image_settings.media_type = "MULTI_LAYER_IMAGE"
    scene.render.image_settings.file_format = "OPEN_EXR_MULTILAYER"
    scene.render.image_settings.color_depth = "32"
    scene.render.filepath = os.path.join(folder, "cycles.exr")
    bpy.ops.render.render(write_still=True)
    return channels(scene.render.filepath)[0], f"{view.name}.CryptoObject"


def compare(name, options):
    with tempfile.TemporaryDirectory() as folder:
        cycles_scenes.make(name, folder, *map(int, options.size.split("x")))
        theirs, their_layer = cycles(folder, options)
        path = os.path.join(folder, "ours.exr")
        command = [options.halfdome, "render", os.path.join(folder, "scene.toml"), "--cryptomatte", "object", "-o", path]
        command += ["--filter", "box", "--size", options.size, "--spp", str(options.spp), "--progress", "none"]
        subprocess.run(command, check=True)
        ours, header = channels(path)
        bpy.context.scene.render.use_compositing = True
        bpy.context.scene.cycles.samples = 1
        picture = bpy.data.images.load(path)
        wrong, worst, farthest = 0, 0, 0
        names = sorted(manifest(header).items())
        for object_name, number in names:
            expected = coverage(ours, "CryptoObject", number)
            difference = np.abs(matte(picture, "CryptoObject", object_name, folder) - expected).max()
            means = np.mean(expected), np.mean(coverage(theirs, their_layer, number))
            distance = abs(means[0] - means[1])
            if difference > SAME or distance > NEAR:
                print(f"{name}: {object_name}: differs by {difference:.1e}; covers {means[0]:.5f}, Cycles' {means[1]:.5f}")
                wrong += 1
            worst, farthest = max(worst, difference), max(farthest, distance)
        print(
            f"{name}: {len(names)} objects: mattes differ by at most {worst:.1e}, means from Cycles' by {farthest:.1e}",
            flush=True,
        )
        return wrong


def main():
    sys.stdout = serve.answers
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", metavar="SCENE", nargs="*", default=["yard", "street"])
    parser.add_argument("--halfdome", default=os.path.join(ROOT, "target", "release", "halfdome"))
    parser.add_argument("--size", default="160x120")
    parser.add_argument("--spp", type=int, default=64)
    options = parser.parse_args()
    sys.exit(1 if sum(compare(name, options) for name in options.scenes) else 0)


if __name__ == "__main__":
    main()
