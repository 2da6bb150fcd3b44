"""Renders a ball of each of glTF's materials with halfdome and with Blender's Cycles, from the same file, and compares them.

usage, after setup-renderers.sh and `cargo build --release`:
    target/renderers/bin/python benches/renderers/materials.py [--halfdome FILE] [--spp N] [--size N] [--out DIR] [NAME...]

For each: the ratio of the means of red, green and blue, ours by Cycles', and FLIP's mean (Andersson et al. 2020), both of the
ball's square. DIR gets `materials.md`, the table, and `materials.png`, a column each: ours, Cycles', FLIP ten times as bright.

What Blender's exporter leaves out is added to the file by hand, and said so in `MATERIALS`.
"""

import argparse
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

sys.path.insert(0, os.path.join(os.path.dirname(__file__), "scenes"))
import glb
import kit

ROOT = os.path.join(os.path.dirname(__file__), "..", "..")
SUN = (0.5, -0.5, 0.7)


def checker(directory):
    y, x = np.mgrid[0:128, 0:128]
    dark = ((x // 16 + y // 16) % 2)[..., None]
    return kit.image(directory, "checker", np.where(dark == 1, np.array([0.75, 0.2, 0.15]), np.array([0.85, 0.8, 0.7])))


def waves(directory):
    y, x = np.mgrid[0:128, 0:128] / 128
    return kit.image(directory, "waves", kit.bumps(np.sin(16 * np.pi * x) * np.sin(16 * np.pi * y), 0.5), data=True)


def holes(directory):
    y, x = np.mgrid[0:128, 0:128]
    opaque = ((x % 16 - 8) ** 2 + (y % 16 - 8) ** 2 > 30).astype(float)
    return kit.image(directory, "holes", np.stack([0.2 + 0 * opaque, 0.5 + 0 * opaque, 0.25 + 0 * opaque, opaque], -1))


def brushed(directory):
    """Blender's own tangents go around z; glTF's follow the coordinates of the picture."""
    made = kit.material("brushed", (0.9, 0.9, 0.9), 0.4, 1, Anisotropic=0.8)
    tangent = made.node_tree.nodes.new("ShaderNodeTangent")
    tangent.direction_type = "UV_MAP"
    made.node_tree.links.new(tangent.outputs[0], made.node_tree.nodes["Principled BSDF"].inputs["Tangent"])
    return made


DECAY = -np.log([0.25, 0.8, 0.6]) / 0.5
# As Blender's exporter writes its node: a reader of its files takes them for `(1 - color) / distance`.
TINTED = {
    "KHR_materials_volume": {
        "thicknessFactor": 1,
        "attenuationDistance": 1 / DECAY.max(),
        "attenuationColor": list(1 - DECAY / DECAY.max()),
    }
}


def tinted(directory):
    """Glass that absorbs: over a metre, all but the square of half of the red."""
    made = kit.material("tinted", (1, 1, 1), 0, Transmission_Weight=1, IOR=1.5)
    tree = made.node_tree
    absorption = tree.nodes.new("ShaderNodeVolumeAbsorption")
    absorption.inputs["Density"].default_value = DECAY.max()
    absorption.inputs["Color"].default_value = (*(1 - DECAY / DECAY.max()), 1)
    tree.links.new(absorption.outputs[0], tree.nodes["Material Output"].inputs["Volume"])
    return made


GLASS = {"Transmission_Weight": 1, "IOR": 1.5}
SOLID = {"KHR_materials_volume": {"thicknessFactor": 1}}
# Name, what makes it, and extensions that are added by hand.
MATERIALS = [
    ("diffuse", lambda _: kit.matte("m", (0.7, 0.45, 0.3)), {}),
    ("plastic", lambda _: kit.material("m", (0.1, 0.3, 0.6), 0.5), {}),
    ("glossy", lambda _: kit.material("m", (0.1, 0.3, 0.6), 0.1), {}),
    ("specular", lambda _: kit.material("m", (0.2, 0.2, 0.2), 0.3, Specular_IOR_Level=0.25, Specular_Tint=(1, 0.5, 0.2, 1)), {}),
    ("gold", lambda _: kit.material("m", (1, 0.78, 0.34), 0.3, 1), {}),
    ("chrome", lambda _: kit.material("m", (0.9, 0.9, 0.9), 0.05, 1), {}),
    ("mirror", lambda _: kit.material("m", (0.9, 0.9, 0.9), 0, 1), {}),
    ("brushed", brushed, {}),
    ("coat", lambda _: kit.material("m", (0.6, 0.05, 0.05), 0.6, Coat_Weight=1, Coat_Roughness=0.05), {}),
    ("sheen", lambda _: kit.matte("m", (0.05, 0.05, 0.2), Sheen_Weight=1, Sheen_Roughness=0.4, Sheen_Tint=(0.8, 0.6, 0.9, 1)), {}),
    (
        "film",
        lambda _: kit.material("m", (0.9, 0.9, 0.9), 0.1, 1, Thin_Film_Thickness=400, Thin_Film_IOR=1.33),
        {"KHR_materials_iridescence": {"iridescenceFactor": 1, "iridescenceIor": 1.33, "iridescenceThicknessMaximum": 400}},
    ),
    ("glass", lambda _: kit.material("m", (1, 1, 1), 0, **GLASS), SOLID),
    ("frosted", lambda _: kit.material("m", (1, 1, 1), 0.3, **GLASS), SOLID),
    (
        "tinted",
        tinted,
        TINTED,
    ),
    ("textured", lambda directory: kit.material("m", roughness=0.4, picture=checker(directory)), {}),
    ("bumpy", lambda directory: kit.material("m", (0.6, 0.6, 0.6), 0.3, normals=waves(directory)), {}),
    ("mask", lambda directory: kit.matte("m", picture=holes(directory), cutout=True), {}),
    ("blend", lambda _: kit.matte("m", (0.2, 0.6, 0.3), Alpha=0.5), {}),
    ("emissive", lambda _: kit.matte("m", (0.5, 0.5, 0.5), Emission_Color=(1, 0.6, 0.2, 1), Emission_Strength=2), {}),
]


def main():
    sys.stdout = serve.answers
    options = parse()
    known = [name for name, *_ in MATERIALS]
    unknown = [name for name in options.names if name not in known]
    if unknown:
        sys.exit(f"no material {', '.join(unknown)}: there are {', '.join(known)}")
    lines, columns = [], []
    for name, make, extensions in MATERIALS:
        if options.names and name not in options.names:
            continue
        ours, theirs = pair(make, extensions, options)
        ratio = ours.mean((0, 1)) / theirs.mean((0, 1))
        flip, mean = difference(theirs, ours)
        lines.append(f"| {name} | {ratio[0]:.4f} {ratio[1]:.4f} {ratio[2]:.4f} | {mean:.4f} |")
        print(lines[-1], flush=True)
        columns.append(np.concatenate([encode(ours), encode(theirs), np.clip(10 * flip, 0, 1)], 0))
    os.makedirs(options.out, exist_ok=True)
    with open(os.path.join(options.out, "materials.md"), "w", encoding="utf-8") as file:
        file.write("| | means by Cycles' | FLIP |\n| --- | --- | --- |\n" + "\n".join(lines) + "\n")
    write_png(os.path.join(options.out, "materials.png"), np.concatenate(columns, 1))


def parse():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--halfdome", default=os.path.join(ROOT, "target/release/halfdome"), help="the program")
    parser.add_argument("--spp", type=int, default=1024, help="samples a pixel")
    parser.add_argument("--size", type=int, default=128, help="pixels along a side")
    parser.add_argument("--out", default="materials", help="the folder for results")
    parser.add_argument("names", nargs="*", metavar="NAME", help="which materials; all by default")
    return parser.parse_args()


def pair(make, extensions, options):
    """The picture by halfdome and that by Cycles."""
    with tempfile.TemporaryDirectory() as directory:
        sky = build(directory, make)
        scene = bpy.context.scene
        description = {"width": options.size, "height": options.size, "sure_bounces": 0}
        cycles_peer.set_output(scene.render, description)
        cycles_peer.set_cycles(scene.cycles, description)
        model = os.path.join(directory, "scene.glb")
        kit.export(model)
        glb.extend(model, "m", extensions)
        with open(os.path.join(directory, "scene.toml"), "w", encoding="utf-8") as file:
            file.write(cycles_scenes.toml(sky))
        picture = os.path.join(directory, "ours.exr")
        size = f"{options.size}x{options.size}"
        command = [options.halfdome, "render", os.path.join(directory, "scene.toml"), "--size", size, "--filter", "box"]
        subprocess.run([*command, "--spp", str(options.spp), "-o", picture], check=True, stdout=subprocess.DEVNULL)
        with OpenEXR.File(picture) as file:
            ours = file.channels()["RGB"].pixels.astype(float)
        theirs, _ = cycles_peer.renderer(scene, directory)(options.spp, 1)
        return ours, theirs.astype(float)


def build(directory, make):
    """A ball on a floor of grey squares, under a sky with a sun that is large enough to be found through glass."""
    kit.begin()
    y, x = np.mgrid[0:64, 0:64]
    squares = np.repeat((0.35 + 0.3 * ((x // 8 + y // 8) % 2))[..., None], 3, 2)
    kit.add("plane", kit.matte("floor", picture=kit.image(directory, "floor", squares)), size=8)
    made = make(directory)
    made.name = "m"
    # Cycles filters encoded colours, and glTF's readers linear ones.
    for node in (node for material in bpy.data.materials for node in material.node_tree.nodes):
        if node.type == "TEX_IMAGE" and node.image.colorspace_settings.name != "Non-Color":
            node.interpolation = "Closest"
    kit.add("uv_sphere", made, at=(0, 0, 1), radius=1, segments=96, ring_count=48, smooth=True)
    kit.camera((0, -5, 2.1), (0, 0, 0.95), 30)
    return kit.sky_picture(directory, kit.clear_sky(SUN, (120, 110, 90), radius=0.1))


def encode(picture):
    """sRGB, cut off at white."""
    picture = np.clip(0.6 * picture, 0, 1)
    return np.where(picture <= 0.0031308, 12.92 * picture, 1.055 * picture ** (1 / 2.4) - 0.055)


def difference(reference, picture):
    """FLIP's map and its mean, of what a screen shows."""
    import flip_evaluator

    reference, picture = (encode(values).astype(np.float32) for values in (reference, picture))
    error, mean, _ = flip_evaluator.evaluate(reference, picture, "LDR", applyMagma=False)
    return np.repeat(error.reshape(*reference.shape[:2], -1)[..., :1], 3, 2), mean


def write_png(path, pixels):
    """Blender's own writer, so that there is no other to install."""
    height, width, _ = pixels.shape
    picture = bpy.data.images.new("picture", width, height)
    full = np.ones((height, width, 4), np.float32)
    full[..., :3] = pixels[::-1]
    picture.pixels.foreach_set(full.ravel())
    picture.filepath_raw, picture.file_format = os.path.abspath(path), "PNG"
    picture.save()


if __name__ == "__main__":
    main()
