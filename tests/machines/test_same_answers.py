"""The same request gives the same counts, whatever the processor and the libraries do.

One machine plays others: BLAS, the C library, numpy and LLVM are told to use what older processors
have; another hull is put in place of Qhull's; and Python computes every kernel itself, without a
compiler. A machine of another kind is compared with the answers that are kept.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from types import SimpleNamespace

import numpy as np
import pytest
from numpy._core._multiarray_umath import __cpu_features__ as cpu_features
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

from ros_pose_stats.mesh import hull
from tests.machines.requests import KEPT, answers
from tests.running import ROOT

WITHOUT_FMA = "glibc.cpu.hwcaps=-AVX2_Usable,-FMA_Usable,-AVX2,-FMA,-FMA4"

PLAYED = {
    "BLAS for SkylakeX": ("AVX512_SKX", {"OPENBLAS_CORETYPE": "SkylakeX"}),
    "BLAS for Haswell": ("AVX2", {"OPENBLAS_CORETYPE": "Haswell"}),
    "BLAS for Prescott": ("SSE3", {"OPENBLAS_CORETYPE": "Prescott"}),
    "C library without FMA": ("AVX2", {"GLIBC_TUNABLES": WITHOUT_FMA}),
    "numpy without AVX2": ("AVX2", {"NPY_DISABLE_CPU_FEATURES": "AVX2 FMA3"}),
}
"""What a processor must have to play another one, and how it is told to."""

SETTINGS = {"as it is": {}, **{name: environment for name, (needed, environment) in PLAYED.items()
                               if cpu_features.get(needed)}}

COMPILED_ANEW = {
    "generic code": {"NUMBA_CPU_NAME": "generic"},
    "code hardly optimised": {"NUMBA_OPT": "1", "NUMBA_LOOP_VECTORIZE": "0"},
}

EXACT = ("part", "first", "drops", "counts")
ROUNDING = 1e-12
"""Of estimates, which may use the libraries."""


@pytest.fixture(scope="module")
def kept():
    return json.loads(KEPT.read_text(encoding="utf-8"))


def asked(file, environment, *arguments):
    """What a process with other settings answers."""
    done = subprocess.run(
        [sys.executable, "-W", "ignore", "-m", "tests.machines.requests", str(file), *arguments],
        env={**os.environ, **environment}, cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return json.loads(file.read_text(encoding="utf-8"))


def assert_same(found, kept):
    assert found.keys() == kept.keys()
    for name, one in found.items():
        for key in EXACT:
            assert one[key] == kept[name][key], (name, key)
        for method, values in one["estimates"].items():
            assert values == pytest.approx(kept[name]["estimates"][method], rel=0.0,
                                           abs=ROUNDING), (name, method)


@pytest.mark.parametrize("setting", SETTINGS)
def test_libraries_of_other_processors(setting, kept, tmp_path):
    assert_same(asked(tmp_path / "answers.json", SETTINGS[setting]), kept)


@pytest.mark.long
@pytest.mark.parametrize("setting", COMPILED_ANEW)
def test_kernels_compiled_otherwise(setting, kept, tmp_path):
    environment = {**COMPILED_ANEW[setting], "NUMBA_CACHE_DIR": str(tmp_path / "cache")}
    assert_same(asked(tmp_path / "answers.json", environment), kept)


@pytest.mark.parametrize("names", [
    ("cube", "loaded", "polyhedron 0"),
    pytest.param(("drum", "pebble"), marks=pytest.mark.long, id="many corners"),
])
def test_kernels_run_by_python(names, kept, tmp_path):
    """Python fuses no multiplication with an addition and reorders nothing: nor did LLVM."""
    found = asked(tmp_path / "answers.json", {"NUMBA_DISABLE_JIT": "1"}, *names)
    assert found == {name: {key: kept[name][key] for key in ("part", "first")} for name in names}


class OtherHulls:
    """Hulls as they might come from other code: computed in another frame and order.

    Flat faces are cut along other diagonals, and planes are rounded differently.
    """

    def __init__(self, seed):
        self.random = np.random.default_rng(seed)
        self.turn = Rotation.random(random_state=np.random.RandomState(seed)).as_matrix()

    def __call__(self, points):
        order = self.random.permutation(len(points))
        found = ConvexHull(points[order] @ self.turn.T)
        chosen = self.random.permutation(len(found.simplices))
        place = np.argsort(chosen)
        equations = found.equations[chosen]
        equations[:, :3] = equations[:, :3] @ self.turn
        return SimpleNamespace(
            simplices=order[found.simplices[chosen]].astype(np.int32), equations=equations,
            neighbors=place[found.neighbors[chosen]].astype(np.int32), volume=found.volume)


def test_a_hull_decides_only_what_the_faces_are(kept, monkeypatch):
    monkeypatch.setattr(hull, "ConvexHull", OtherHulls(1))
    cube = np.array([(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
    plain = {tuple(sorted(one)) for one in ConvexHull(cube).simplices.tolist()}
    assert {tuple(sorted(one)) for one in OtherHulls(1)(cube).simplices.tolist()} != plain
    assert_same(answers(), kept)
