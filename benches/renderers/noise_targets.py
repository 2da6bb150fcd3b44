"""Renders scenes to a noise target, and compares the error that was asked for and estimated with the true one.

usage, after setup-renderers.sh and `cargo build --release`:
    target/renderers/bin/python benches/renderers/noise_targets.py [--halfdome FILE] [--noise PERCENT] [--size WxH]
        [--runs N] [--reference N] [--limit N] [--threads N] [SCENE...]

The true error is the root mean square over pixels, relative as `--noise` has it, against the mean of two long renders, less
what these two differ by. The bias is that of the mean of all runs' pictures, beside its standard error among runs.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile

import cycles_scenes
import numpy as np
import OpenEXR
import serve

ROOT = os.path.join(os.path.dirname(__file__), "..", "..")
SCENES = ["cornell", "yard", "bulbs", "window", "hdri"]
REC709 = np.array([0.2126, 0.7152, 0.0722])


def luminance(path):
    with OpenEXR.File(path) as file:
        channels = file.channels()
        pixels = channels["RGB"].pixels if "RGB" in channels else np.stack([channels[c].pixels for c in "RGB"], -1)
        return np.maximum(np.asarray(pixels, np.float64) @ REC709, 0)


class Scene:
    def __init__(self, name, folder, options):
        self.folder, self.options = folder, options
        self.file = name
        if name != "cornell":
            cycles_scenes.make(name, folder, *map(int, options.size.split("x")))
            self.file = os.path.join(folder, "scene.toml")

    def render(self, name, *options):
        """The luminance of the picture, and the statistics."""
        picture, statistics = (os.path.join(self.folder, f"{name}.{suffix}") for suffix in ("exr", "json"))
        command = [self.options.halfdome, "render", self.file, "--size", self.options.size, "--progress", "none"]
        command += ["--threads", str(self.options.threads)] if self.options.threads else []
        ended = subprocess.run([*command, *options, "--stats-json", statistics, "-o", picture], check=False).returncode
        if ended not in (0, 4):
            raise SystemExit(f"halfdome ended with code {ended}")
        with open(statistics, encoding="utf-8") as file:
            return luminance(picture), json.load(file)


def compare(name, options):
    with tempfile.TemporaryDirectory() as folder:
        scene = Scene(name, folder, options)
        long = [scene.render("long", "--spp", str(options.reference), "--seed", str(seed))[0] for seed in (1001, 1002)]
        reference = (long[0] + long[1]) / 2
        least = 0.1 * np.sqrt(reference).mean() ** 2
        relative = np.maximum(reference, least)
        own = (((long[0] - long[1]) / 2 / relative) ** 2).mean()
        errors, means, estimates, samples, seconds = [], [], [], [], []
        for seed in range(options.runs):
            target = ["--noise", f"{options.noise}%", "--spp", str(options.limit), "--seed", str(seed)]
            picture, statistics = scene.render("run", *target)
            errors.append((((picture - reference) / relative) ** 2).mean() - own)
            means.append(picture.mean() / reference.mean() - 1)
            estimates.append(statistics["error"])
            samples.append((statistics["least_samples"], statistics["most_samples"]))
            seconds.append(statistics["processor_seconds"])
        spread = np.std(means, ddof=1) / len(means) ** 0.5 if len(means) > 1 else float("nan")
        print(
            f"{name:9} asked {options.noise:g}%  estimated {100 * np.mean(estimates):.2f}%  "
            f"true {100 * np.mean(errors) ** 0.5:.2f}% ({', '.join(f'{100 * max(e, 0) ** 0.5:.2f}' for e in errors[:4])})  "
            f"reference {100 * own ** 0.5:.2f}%  bias {100 * np.mean(means):+.3f}% ± {100 * spread:.3f}%  "
            f"samples {min(s[0] for s in samples)} to {max(s[1] for s in samples)}  {np.mean(seconds):.1f} s",
            flush=True,
        )


def main():
    sys.stdout = serve.answers
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", metavar="SCENE", nargs="*", default=SCENES)
    parser.add_argument("--halfdome", default=os.path.join(ROOT, "target", "release", "halfdome"))
    parser.add_argument("--noise", type=float, default=2)
    parser.add_argument("--size", default="160x120")
    parser.add_argument("--runs", type=int, default=2)
    parser.add_argument("--reference", type=int, default=8192, help="samples a pixel of each half")
    parser.add_argument("--limit", type=int, default=1 << 20, help="samples a pixel of a run, at most")
    parser.add_argument("--threads", type=int)
    options = parser.parse_args()
    for name in options.scenes:
        compare(name, options)


if __name__ == "__main__":
    main()
