"""Makes one of the scenes in `scenes` and renders it with Blender's Cycles on one thread; `serve.py` says how to ask it.

arguments: the scene's name, a folder, width and height. The folder gets `scene.glb` and `scene.toml`, from which halfdome
renders the same, and `scene.json`, for Mitsuba.
"""

import importlib
import json
import os
import sys
import tempfile

import cycles_peer
import serve

import bpy

sys.path.insert(0, os.path.join(os.path.dirname(__file__), "scenes"))
import kit


def main():
    name, directory, width, height = sys.argv[1], sys.argv[2], int(sys.argv[3]), int(sys.argv[4])
    description = make(name, directory, width, height)
    scene = bpy.context.scene
    with open(os.path.join(directory, "scene.json"), "w", encoding="utf-8") as file:
        json.dump(description, file)
    with tempfile.TemporaryDirectory() as pictures:
        about = f"Blender {bpy.app.version_string}, Cycles, light tree"
        serve.serve(about, cycles_peer.renderer(scene, pictures))


def make(name, directory, width, height):
    """Builds the scene in Blender, ready to be rendered, and writes `scene.glb` and `scene.toml` in the folder; gives what
    Mitsuba needs to know."""
    sky = importlib.import_module(name).build(directory)
    scene = bpy.context.scene
    description = {"width": width, "height": height, "sure_bounces": 0}
    cycles_peer.set_output(scene.render, description)
    cycles_peer.set_cycles(scene.cycles, description)
    # The file's camera has the picture's shape, and so comes after it.
    kit.export(os.path.join(directory, "scene.glb"))
    with open(os.path.join(directory, "scene.toml"), "w", encoding="utf-8") as file:
        file.write(toml(sky))
    return {**description, "model": os.path.join(directory, "scene.glb"), "sky": sky}


def toml(sky):
    """The scene file. halfdome's pictures of skies begin a quarter of a turn from where Blender's do."""
    lines = ["[scene]", 'file = "scene.glb"', "[sky]"]
    if "sky" in sky:
        lines.append(f"radiance = {sky['sky']}")
    if "picture" in sky:
        lines += [f'picture = "{os.path.basename(sky["picture"])}"', "rotation = 270"]
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    main()
