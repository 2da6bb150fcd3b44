#!/usr/bin/env python3
"""One picture by HyperQueue: hq_render.py [--local] SCENE OUTPUT PARTS [OPTIONS OF halfdome render]

A server and workers must run, and all see this folder; with --local they are started here.
Needs `pip install hyperqueue`."""
import glob
import pathlib
import subprocess
import sys
import tempfile

from hyperqueue import Client, Job, LocalCluster
from hyperqueue.cluster import WorkerConfig


PART = pathlib.Path(__file__).resolve().with_name("part.sh")


def render(client, scene, parts, options, folder):
    job = Job()
    for part in range(1, parts + 1):
        job.program([str(PART), folder, str(part), str(parts), scene, *options])
    client.wait_for_jobs([client.submit(job)])


def main():
    arguments = sys.argv[1:]
    is_local = arguments[:1] == ["--local"]
    if is_local:
        arguments.pop(0)
    scene, output, parts, *options = arguments
    with tempfile.TemporaryDirectory(dir=".", prefix="farm.") as folder:
        if is_local:
            with LocalCluster() as cluster:
                cluster.start_worker(WorkerConfig())
                render(cluster.client(), scene, int(parts), options, folder)
        else:
            render(Client(), scene, int(parts), options, folder)
        subprocess.run(["halfdome", "merge", *glob.glob(f"{folder}/*.hdf"), "-o", output], check=True)


main()
