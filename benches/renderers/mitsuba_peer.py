"""Renders with Mitsuba 3's path tracer in its LLVM variant, on one thread; `serve.py` says how to ask it."""

import mitsuba_serve
import serve
from mitsuba_serve import rgb, sensor

import mitsuba as mi
import numpy as np


def load(description):
    transform = mi.ScalarTransform4f().look_at(description["eye"], description["target"], description["up"])
    scene = {
        "type": "scene",
        # Mitsuba counts surfaces: this is the first at which roulette may end a path.
        "integrator": {"type": "path", "max_depth": -1, "rr_depth": description["sure_bounces"] + 1},
        "sensor": sensor(description, transform, description["vfov"]),
    }
    for number, mesh in enumerate(description["meshes"]):
        scene[f"mesh{number}"] = load_mesh(mesh)
    return mi.load_dict(scene)


def load_mesh(description):
    """Its back is black, which no path of a closed scene sees, and which costs less than a surface of two sides."""
    properties = mi.Properties()
    properties["bsdf"] = mi.load_dict({"type": "diffuse", "reflectance": rgb(description["diffuse"])})
    if any(description["emission"]):
        properties["emitter"] = mi.load_dict({"type": "area", "radiance": rgb(description["emission"])})
    positions, triangles = np.float32(description["positions"]), np.uint32(description["triangles"])
    mesh = mi.Mesh(description["name"], len(positions), len(triangles), props=properties)
    parameters = mi.traverse(mesh)
    parameters["vertex_positions"] = positions.ravel()
    parameters["faces"] = triangles.ravel()
    parameters.update()
    return mesh


mitsuba_serve.answer(load(serve.scene()))
