"""Renders a `.glb` of `cycles_scenes.py` with Mitsuba 3's path tracer in its LLVM variant, on one thread; `serve.py` says how to
ask it. Diffuse materials are the same; others are Mitsuba's own principled one, so that noise can be compared, but not pictures.
"""

import math
import os
import tempfile

import gltf
import mitsuba_serve
import serve
from mitsuba_serve import rgb, sensor

import mitsuba as mi
import numpy as np
import OpenEXR


def main():
    description = serve.scene()
    with tempfile.TemporaryDirectory() as directory:
        scene = Loader(gltf.Model(description["model"]), directory).scene(description)
    mitsuba_serve.answer(scene)


class Loader:
    """Turns a model into Mitsuba's scene; `directory` gets its pictures."""

    def __init__(self, model, directory):
        self.model, self.directory, self.materials = model, directory, {}

    def scene(self, description):
        scene = {"type": "scene", "integrator": {"type": "path", "max_depth": -1}}
        camera, matrix = self.model.cameras[0]
        # glTF's cameras look along -z.
        pose = mi.ScalarTransform4f(matrix @ np.diag([-1.0, 1, -1, 1]))
        scene["sensor"] = sensor(description, pose, math.degrees(camera["perspective"]["yfov"]))
        if "sky" in description["sky"]:
            scene["sky"] = {"type": "constant", "radiance": rgb(description["sky"]["sky"])}
        if "picture" in description["sky"]:
            turn = mi.ScalarTransform4f().rotate([0, 1, 0], 90)
            # Mitsuba waits for ever if it reads an EXR with one thread.
            with OpenEXR.File(description["sky"]["picture"]) as file:
                sky = mi.Bitmap(np.ascontiguousarray(file.channels()["RGB"].pixels))
            scene["sky"] = {"type": "envmap", "bitmap": sky, "to_world": turn}
        for number, (light, matrix) in enumerate(self.model.lights):
            scene[f"light{number}"] = lamp(light, matrix)
        for number, mesh in enumerate(self.model.meshes):
            scene[f"mesh{number}"] = self.mesh(*mesh)
        return mi.load_dict(scene)

    def mesh(self, name, positions, normals, coordinates, triangles, material):
        properties = mi.Properties()
        properties["bsdf"] = self.material(material)
        glow = np.array(material.get("emissiveFactor", (0, 0, 0)))
        glow = glow * extension(material, "emissive_strength").get("emissiveStrength", 1)
        if glow.any():
            properties["emitter"] = mi.load_dict({"type": "area", "radiance": rgb(glow)})
        smooth, textured = normals is not None, coordinates is not None
        mesh = mi.Mesh(name, len(positions), len(triangles), props=properties, has_vertex_normals=smooth, has_vertex_texcoords=textured)
        parameters = mi.traverse(mesh)
        parameters["vertex_positions"] = positions.astype(np.float32).ravel()
        parameters["faces"] = triangles.ravel()
        if smooth:
            parameters["vertex_normals"] = normals.astype(np.float32).ravel()
        if textured:
            parameters["vertex_texcoords"] = coordinates.astype(np.float32).ravel()
        parameters.update()
        return mesh

    def material(self, material):
        name = material["name"]
        if name not in self.materials:
            self.materials[name] = mi.load_dict(self.surface(material))
        return self.materials[name]

    def surface(self, material):
        shine = material.get("pbrMetallicRoughness", {})
        color = rgb(shine.get("baseColorFactor", (1, 1, 1, 1))[:3])
        if "baseColorTexture" in shine:
            color = {"type": "bitmap", "filename": self.picture(shine["baseColorTexture"])}
        metallic, roughness = shine.get("metallicFactor", 1), shine.get("roughnessFactor", 1)
        ior = extension(material, "ior").get("ior", 1.5)
        if extension(material, "transmission").get("transmissionFactor", 0) > 0:
            return {"type": "dielectric", "int_ior": ior}
        if extension(material, "specular").get("specularFactor", 1) == 0 and metallic == 0:
            surface = {"type": "diffuse", "reflectance": color}
        else:
            surface = {"type": "principled", "base_color": color, "metallic": metallic, "roughness": roughness, "eta": ior}
        if "normalTexture" in material:
            normals = {"type": "bitmap", "raw": True, "filename": self.picture(material["normalTexture"])}
            surface = {"type": "normalmap", "normalmap": normals, "bsdf": surface}
        surface = {"type": "twosided", "bsdf": surface}
        if material.get("alphaMode") == "MASK":
            pixels = np.array(mi.Bitmap(self.picture(shine["baseColorTexture"])))
            opaque = (pixels[..., 3:] >= 255 * material.get("alphaCutoff", 0.5)).astype(np.float32)
            opacity = {"type": "bitmap", "bitmap": mi.Bitmap(opaque), "raw": True, "filter_type": "nearest"}
            surface = {"type": "mask", "opacity": opacity, "bsdf": surface}
        return surface

    def picture(self, texture):
        data, ending = self.model.image(texture)
        path = os.path.join(self.directory, f"{texture['index']}.{ending}")
        with open(path, "wb") as file:
            file.write(data)
        return path


def extension(material, name):
    return material.get("extensions", {}).get(f"KHR_materials_{name}", {})


def lamp(light, matrix):
    """A punctual light, which shines along its -z."""
    strength = np.array(light.get("color", (1, 1, 1))) * light.get("intensity", 1)
    if light["type"] == "point":
        return {"type": "point", "position": list(matrix[:3, 3]), "intensity": rgb(strength)}
    pose = mi.ScalarTransform4f(matrix @ np.diag([-1.0, 1, -1, 1]))
    if light["type"] == "directional":
        return {"type": "directional", "to_world": pose, "irradiance": rgb(strength)}
    inner, outer = light["spot"].get("innerConeAngle", 0), light["spot"].get("outerConeAngle", math.pi / 4)
    # Mitsuba's own edge is linear in the angle; a picture gives it glTF's, the square of a ramp in the cosine.
    side = 512
    place = (np.arange(side) + 0.5) / side * 2 - 1
    cosine = 1 / np.sqrt(1 + (place[:, None] ** 2 + place**2) * math.tan(outer) ** 2)
    edge = np.clip((cosine - math.cos(outer)) / max(math.cos(inner) - math.cos(outer), 1e-6), 0, 1) ** 2
    profile = {"type": "bitmap", "bitmap": mi.Bitmap(np.repeat(edge[..., None], 3, 2).astype(np.float32)), "raw": True}
    angle = math.degrees(outer)
    return {"type": "spot", "to_world": pose, "intensity": rgb(strength), "cutoff_angle": angle, "beam_width": 0.999 * angle, "texture": profile}


main()
