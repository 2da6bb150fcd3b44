"""What the scripts for Mitsuba 3 share: its LLVM variant on one thread, a film, and answers to `serve.py`'s requests."""

import time

import serve

import drjit as dr
import mitsuba as mi
import numpy as np

VARIANT = "llvm_ad_rgb"

mi.set_variant(VARIANT)
dr.set_thread_count(1)


def answer(scene):
    """Renders a scene as often as it is asked to."""

    def render(spp, seed):
        start = time.process_time()
        picture = mi.render(scene, spp=spp, seed=seed)
        dr.eval(picture)
        dr.sync_thread()
        return np.array(picture), time.process_time() - start

    serve.serve(f"Mitsuba {mi.__version__}, {VARIANT}, independent sampler", render)


def sensor(description, to_world, vfov):
    """A pinhole camera that looks along its z, with a box filter of one pixel; `vfov` in degrees."""
    film = {
        "type": "hdrfilm",
        "width": description["width"],
        "height": description["height"],
        "rfilter": {"type": "box"},
        "pixel_format": "rgb",
        "component_format": "float32",
    }
    return {
        "type": "perspective",
        "to_world": to_world,
        "fov": vfov,
        "fov_axis": "y",
        "film": film,
        "sampler": {"type": "independent"},
    }


def rgb(value):
    return {"type": "rgb", "value": [float(channel) for channel in value]}
