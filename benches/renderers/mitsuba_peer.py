"""Renders with Mitsuba 3's path tracer in its LLVM variant, on one thread; `serve.py` says how to ask it."""

import time

import serve

import drjit as dr
import mitsuba as mi
import numpy as np

VARIANT = "llvm_ad_rgb"


def main():
    mi.set_variant(VARIANT)
    dr.set_thread_count(1)
    scene = load(serve.scene())

    def render(spp, seed):
        start = time.process_time()
        picture = mi.render(scene, spp=spp, seed=seed)
        dr.eval(picture)
        dr.sync_thread()
        return np.array(picture), time.process_time() - start

    serve.serve(f"Mitsuba {mi.__version__}, {VARIANT}, independent sampler", render)


def load(description):
    transform = mi.ScalarTransform4f().look_at(description["eye"], description["target"], description["up"])
    film = {
        "type": "hdrfilm",
        "width": description["width"],
        "height": description["height"],
        "rfilter": {"type": "box"},
        "pixel_format": "rgb",
        "component_format": "float32",
    }
    scene = {
        "type": "scene",
        # Mitsuba counts surfaces: this is the first at which roulette may end a path.
        "integrator": {"type": "path", "max_depth": -1, "rr_depth": description["sure_bounces"] + 1},
        "sensor": {
            "type": "perspective",
            "to_world": transform,
            "fov": description["vfov"],
            "fov_axis": "y",
            "film": film,
            "sampler": {"type": "independent"},
        },
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


def rgb(value):
    return {"type": "rgb", "value": value}


main()
