"""What the peers' scripts share: they read a scene, then render it as often as they are asked to.

The scene is the JSON file that the program's first argument names. It is in metres and linear sRGB: `width`, `height`
and `vfov` (vertical, in degrees) of a pinhole camera at `eye` that looks at `target`, a box filter of one pixel,
`sure_bounces` before Russian roulette, and `meshes` with `positions`, `triangles` (counter-clockwise from the front),
`diffuse` reflectance and `emission` of the front side in W/(m² sr).

A request is one line of JSON on standard input: `spp`, `seed`, and `picture`, the file that gets 32-bit floats in the
machine's byte order: red, green and blue, row by row from the top left corner. The answer is one line on standard
output: `seconds` of the processor, which rendering took. The first line comes unasked and says what
the renderer is, `about`.
"""

import json
import os
import sys

import numpy as np

# Standard output is for answers alone: what the renderer prints there goes nowhere.
answers = os.fdopen(os.dup(1), "w")
os.dup2(os.open(os.devnull, os.O_WRONLY), 1)


def scene():
    """The scene to render."""
    with open(sys.argv[1], encoding="utf-8") as file:
        return json.load(file)


def serve(about, render):
    """Answers requests until there are no more; `render(spp, seed)` gives the picture's array and the seconds."""
    answer(about=about)
    for line in sys.stdin:
        request = json.loads(line)
        pixels, seconds = render(request["spp"], request["seed"])
        np.ascontiguousarray(pixels, dtype=np.float32).tofile(request["picture"])
        answer(seconds=seconds)


def answer(**values):
    print(json.dumps(values), file=answers, flush=True)
