"""Inputs that hang or crash are caught and named, and the next one is tried all the same."""

from __future__ import annotations

import os
import time

from tests.fuzz.trial import Outcome
from tests.fuzz.watched import Job, Watched, answer


def trouble(kind, seed, thorough):
    """A stand-in for a trial: what the kind says."""
    if kind == "hangs":
        time.sleep(60.0)
    if kind == "crashes":
        os.abort()
    return Outcome(kind, seed)


def serve_trouble(connection):
    answer(connection, trouble)


def test_what_hangs_or_crashes_is_named():
    with Watched(0.5, serve_trouble) as watched:
        jobs = [Job("fine", 1), Job("hangs", 2), Job("fine", 3), Job("crashes", 4), Job("fine", 5)]
        found = list(watched.outcomes(jobs))
    assert [(one.kind, one.seed, one.faults) for one in found] == [
        ("fine", 1, ()), ("hangs", 2, ("no answer within 0.5 s",)), ("fine", 3, ()),
        ("crashes", 4, ("the process ended with status -6",)), ("fine", 5, ())]


def test_no_process_is_left_behind():
    with Watched(0.5, serve_trouble) as watched:
        process = watched._process
        assert process.is_alive()
    assert process.exitcode is not None
