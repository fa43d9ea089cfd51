"""What the commands of one checkout say of meshes, as digests; run with that checkout's package.

A line of JSON for each mesh. Nothing but the command line is imported, for rooms may have other
names there.
"""

from __future__ import annotations

import contextlib
import hashlib
import io
import json
import sys
from pathlib import Path

from mcap.reader import make_reader

from ros_pose_stats.cli import main

TIMED = ("seconds", "time", "begin", "end", "queued", "started", "ended", "version", "job_id")
"""Keys whose values say when, how long, or by which version."""

def run_command(arguments):
    """What a command prints, and its exit status."""
    out, said = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(said):
        status = main(arguments)
    return status, out.getvalue(), said.getvalue()


def without_times(value):
    """A JSON value less the times in it."""
    if isinstance(value, dict):
        return {key: without_times(one) for key, one in value.items() if key not in TIMED}
    return [without_times(one) for one in value] if isinstance(value, list) else value


def answer_for(mesh, drops, work):
    """Digests of what the commands say of a mesh, or their refusal."""
    part = [mesh, "--unit", "mm"]
    asked = {
        "estimate": ["estimate", *part, "--method", "all", "--json"],
        "simulate": ["simulate", *part, "--drops", str(drops), "--seed", "5", "--json"],
        "lattice": ["simulate", *part, "--drops", str(drops), "--seed", "5", "--restitution",
                    "0.8", "--sampling", "lattice", "--json"],
    }
    found = {}
    for name, arguments in asked.items():
        status, out, said = run_command(arguments)
        plain = without_times(json.loads(out)) if status == 0 else said
        found[name] = digest_of(json.dumps([status, plain]).encode())
    if Path(mesh).parent.name == "demo":
        film = Path(work) / f"{Path(mesh).stem}.mcap"
        status, _, said = run_command(["animate", *part, "--drop", "3", "-o", str(film)])
        found["recorded drop"] = digest_of(_messages(film) if status == 0 else said.encode())
    return found


def _messages(film):
    """All messages of a recorded drop: the file around them says when it was written."""
    with film.open("rb") as stream:
        return b"".join(b"%s %d %s" % (channel.topic.encode(), message.log_time, message.data)
                        for _, channel, message in make_reader(stream).iter_messages())


def digest_of(content):
    return hashlib.sha256(content).hexdigest()


def print_digests(drops, work, *meshes):
    """Print a line for each mesh."""
    for mesh in meshes:
        print(json.dumps([mesh, answer_for(mesh, int(drops), work)]), flush=True)


if __name__ == "__main__":
    print_digests(*sys.argv[1:])
