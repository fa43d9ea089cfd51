"""Meshes of every bad kind, ten thousand in all: invariants hold or the input is refused, in time.
"""

from __future__ import annotations

import pytest

from tests.fuzz.large import large_outcomes
from tests.fuzz.large_meshes import CASES
from tests.fuzz.meshes import KINDS
from tests.fuzz.watched import Job, Watched

MESHES = 270
"""Inputs of each kind: 10 260 in all."""

FEW = 20
"""How many of them are tried in every run of the tests."""

THOROUGH = 5
"""How many of those are asked about at every tolerance and given in other ways too."""

COMPARED = {"leaning": 1, "needle": 3, "plate": 3, "rings": 3}
"""Fewest of the thorough ones about which rounding decides nothing; other kinds: a third."""


@pytest.fixture(scope="module")
def watched():
    """A process that is started anew after an input that it does not survive."""
    with Watched() as process:
        yield process


def test_there_are_ten_thousand():
    assert MESHES * len(KINDS) >= 10_000


def assert_sound(watched, kind, jobs):
    """The outcomes of jobs of one kind, none of which has a fault."""
    outcomes = list(watched.outcomes(jobs))
    assert [(found.seed, found.faults) for found in outcomes if found.faults] == []
    taken = sum(not found.refusal for found in outcomes)
    assert KINDS[kind].fate == "either" or taken == {
        "taken": len(outcomes), "refused": 0}[KINDS[kind].fate]
    return outcomes


@pytest.mark.parametrize("kind", KINDS)
def test_invariants_hold_or_the_input_is_refused(watched, kind):
    outcomes = assert_sound(
        watched, kind, [Job(kind, seed, seed < THOROUGH) for seed in range(FEW)])
    if KINDS[kind].same:
        compared = sum(found.compared == "same" for found in outcomes)
        assert compared >= COMPARED.get(kind, THOROUGH // 3)


@pytest.mark.long
@pytest.mark.parametrize("kind", KINDS)
def test_they_hold_for_ten_thousand(watched, kind):
    outcomes = assert_sound(
        watched, kind, [Job(kind, seed, False) for seed in range(FEW, MESHES)])
    # Of a kind that may go either way some are taken, or it would test nothing.
    assert KINDS[kind].fate != "either" or not all(found.refusal for found in outcomes)


@pytest.mark.long
def test_large_bad_inputs_end():
    # Each under a time limit, which shows as a fault.
    outcomes = list(large_outcomes())
    assert [(found.kind, found.faults) for found in outcomes if found.faults] == []
    assert [found.kind for found in outcomes] == list(CASES)
    assert all(found.seed > 30_000 for found in outcomes)
    assert {found.kind for found in outcomes if found.refusal} == {"coincident", "flat"}
