"""Whether two checkouts answer alike, to the last bit: `python -m tests.machines.checkouts OTHER`.

    python -m tests.machines.checkouts OTHER [--polyhedra N] [--drops N] [MESH ...]

Each checkout answers in processes of its own, by the commands that users call, for the demo
parts, the meshes that are named and polyhedra that this checkout makes: all estimates and drops
as JSON, recorded drops byte for byte, and what the bag of a node that was sent the demo parts
holds. Only what was timed may differ. Ends with status 1 where anything else does.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from ros_pose_stats.shapes.demo_parts import write_demo_parts
from ros_pose_stats.shapes.random_polyhedra import random_polyhedron
from tests.bodies import write_stl
from tests.machines import command_digests
from tests.machines.command_digests import digest_of, without_times
from tests.ros.harness.node import NodeProcess
from tests.running import ROOT

DEMO = "demo"
SETTLED = 12.0
"""Seconds that a node is left to answer for what it was sent."""


def answers_of(checkout, drops, meshes, work):
    """Digests by mesh, by a process that imports one checkout alone."""
    Path(work).mkdir()
    # The other checkout may not know this module: it runs as a script.
    script = Path(command_digests.__file__).read_text(encoding="utf-8")
    done = subprocess.run(
        [sys.executable, "-c", script, str(drops), str(work), *meshes],
        env=_environment(checkout), cwd=checkout, stdout=subprocess.PIPE, text=True, check=True)
    found = dict(json.loads(line) for line in done.stdout.splitlines())
    return found | {"bag of a node": bag_of(checkout, work, [
        mesh for mesh in meshes if Path(mesh).parent.name == DEMO])}


def bag_of(checkout, work, meshes):
    """Digests of what a node put on record of the parts that it was sent."""
    command = [sys.executable, "-m", "ros_pose_stats"]
    runs = Path(work) / "runs"
    environment = {**_environment(checkout), "ROS_DOMAIN_ID": str(os.getpid() % 100 + 1)}
    with NodeProcess(runs, environment=environment, folder=checkout).ready():
        for mesh in meshes:
            subprocess.run([*command, "publish", mesh, "--unit", "mm", "--seconds", "3"],
                           env=environment, cwd=checkout, check=True, capture_output=True)
        time.sleep(SETTLED)
    said = subprocess.run([*command, "bag", *map(str, runs.iterdir()), "--json"], check=True,
                          env=environment, cwd=checkout, capture_output=True, text=True).stdout
    return {part["part_id"]: digest_of(json.dumps(without_times(part)).encode())
            for part in json.loads(said)["parts"]}


def _environment(checkout):
    return {**os.environ, "PYTHONPATH": str(checkout), "PYTHONWARNINGS": "ignore"}


def differences(one, other):
    """Names of the answers that are not the same."""
    return [f"{mesh}: {key}" for mesh, found in one.items() for key in found | other[mesh]
            if found.get(key) != other[mesh].get(key)]


def compare(arguments):
    """Run both checkouts, print what differs, and return the exit status."""
    parser = argparse.ArgumentParser(prog="tests.machines.checkouts", description=__doc__)
    parser.add_argument("other", type=Path, help="root of the other checkout")
    parser.add_argument("meshes", nargs="*", help="more mesh files, in millimetres")
    parser.add_argument("--polyhedra", type=int, default=200)
    parser.add_argument("--drops", type=int, default=200)
    options = parser.parse_intermixed_args(arguments)
    with tempfile.TemporaryDirectory() as folder:
        demo = Path(folder) / DEMO
        write_demo_parts(demo)
        meshes = [*sorted(map(str, demo.glob("*.stl"))),
                  *(str(Path(mesh).resolve()) for mesh in options.meshes)]
        for number in range(options.polyhedra):
            part = random_polyhedron(3, number, 0.25).part()
            meshes.append(str(write_stl(Path(folder) / f"polyhedron_{number}.stl",
                                        (part.vertices, part.triangles))))
        found = [answers_of(checkout, options.drops, meshes, Path(folder) / name)
                 for name, checkout in (("this", ROOT), ("other", options.other.resolve()))]
    unlike = differences(*found)
    print("\n".join(unlike))
    print(f"{sum(map(len, found[0].values()))} answers for {len(meshes)} parts and a node's bag: "
          + (f"{len(unlike)} differ" if unlike else "all alike"))
    return 1 if unlike else 0


if __name__ == "__main__":
    sys.exit(compare(sys.argv[1:]))
