"""What a dataset may be made of, how its drops are seeded, blocked and cut into pieces."""

from __future__ import annotations

import itertools
import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ros_pose_stats.errors import RequestError
from ros_pose_stats.study.dataset import DatasetSpec

NAN = float("nan")
restitutions = st.lists(st.floats(0.0, 0.999).map(lambda one: round(one, 6)), min_size=1,
                        max_size=5, unique=True).map(tuple)
specs = st.builds(DatasetSpec, st.integers(1, 5000), st.integers(1, 500_000), restitutions,
                  st.floats(0.0, 10.0), st.sampled_from(["inertia", "second"]),
                  st.integers(0, 2 ** 64 - 1), st.floats(0.1, 100.0))


class TestRefusals:
    @pytest.mark.parametrize(("name", "value"), [
        ("bodies", 0), ("bodies", -1), ("bodies", 1_000_001), ("bodies", True), ("bodies", 2.0),
        ("bodies", "3"), ("drops", 0), ("drops", 10 ** 9), ("drops", NAN), ("drops", None),
        ("seed", -1), ("seed", 2 ** 64), ("seed", 1.0), ("seed", False),
        ("shift", NAN), ("shift", -0.25), ("shift", float("inf")), ("shift", True),
        ("shift_moment", "first"), ("shift_moment", None),
        ("restitutions", ()), ("restitutions", (1.0,)), ("restitutions", (-0.1,)),
        ("restitutions", (NAN,)), ("restitutions", (0.5, 0.2, 0.5)), ("restitutions", (True,)),
        ("restitutions", (0.5, 0.5 + 1e-13)), ("restitutions", ("0.5",)),
        ("drop_height", 0.0), ("drop_height", NAN), ("drop_height", None)])
    def test_each_names_what_came(self, name, value):
        with pytest.raises(RequestError) as refused:
            DatasetSpec(**{name: value})
        assert "\n" not in str(refused.value)
        assert refused.value.remedy

    @given(st.one_of(st.none(), st.booleans(), st.floats(), st.text(), st.binary()))
    def test_counts_are_whole_numbers(self, value):
        for name in ("bodies", "drops", "seed"):
            with pytest.raises(RequestError):
                DatasetSpec(**{name: value})


class TestPlainValues:
    @given(specs)
    def test_json_and_back(self, spec):
        assert DatasetSpec.from_dict(json.loads(json.dumps(spec.as_dict()))) == spec

    def test_equal_specs_read_alike(self):
        whole = DatasetSpec(1, 1, (0,), 1, "inertia", 1, 20)
        assert json.dumps(whole.as_dict()) == json.dumps(
            DatasetSpec(1, 1, (0.0,), 1.0, "inertia", 1, 20.0).as_dict())


class TestBlocksAndPieces:
    @given(specs)
    def test_blocks_cover_the_drops(self, spec):
        lengths = np.diff(spec.block_ends, prepend=0)
        assert spec.block_ends[-1] == spec.drops
        assert (lengths[:-1] == spec.block).all()
        assert 1 <= lengths[-1] <= spec.block
        assert spec.block >= 100
        assert len(lengths) <= 100

    @given(specs)
    def test_pieces_cover_the_bodies_in_order(self, spec):
        ends = [first + count for first, count in spec.chunks]
        assert [first for first, _ in spec.chunks] == [0, *ends[:-1]]
        assert ends[-1] == spec.bodies
        assert all(1 <= count <= 32 for _, count in spec.chunks)


class TestSeedsOfDrops:
    def test_all_differ(self):
        places = itertools.product((1, 2, 2 ** 64 - 1), range(40), (0.0, 0.2, 0.5, 0.8), (0, 1))
        seeds = [DatasetSpec(seed=seed).drop_seed(body, restitution, run)
                 for seed, body, restitution, run in places]
        assert len(set(seeds)) == len(seeds)
        assert all(0 <= seed < 2 ** 64 for seed in seeds)

    def test_neither_size_nor_shift_changes_them(self):
        """A longer dataset begins with the shorter one; all shifts share their noise."""
        assert (DatasetSpec(5, 10, (0.2,), 1.0).drop_seed(3, 0.2)
                == DatasetSpec(1057, 1000).drop_seed(3, 0.2))
