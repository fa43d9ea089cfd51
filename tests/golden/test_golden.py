# Copyright 2026 ros_pose_stats authors
#
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this
# file except in compliance with the License. You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software distributed under
# the License is distributed on an "AS IS" BASIS, WITHOUT WARRANTIES OR CONDITIONS OF
# ANY KIND, either express or implied. See the License for the specific language
# governing permissions and limitations under the License.

"""What the commands answer for forty-five parts is what they answered before, on any
machine.

One machine plays an older one that has another library of hulls: BLAS, the C library,
numpy and LLVM are told to use what that has, and another hull is put in place of
Qhull's. And Python computes every kernel itself. Counts, digests and words are exact;
estimates, which may use the libraries, are so but for rounding (`comparing.ROUNDING`).
"""

import json
import re
from pathlib import Path

import pytest

from tests.golden import answers
from tests.golden.comparing import differences
from tests.golden.machines import COMPILED_OTHERWISE, MACHINES, OLDEST
from tests.golden.running import KEPT, answers_of, write_parts

ALL = json.loads(KEPT.read_text(encoding="utf-8"))
SLOW = ".STEP"
"""Each request reads the file anew in a process of its own."""

PARTS = sorted({name.partition(": ")[0] for name in ALL if ": " in name})

CORE_PARTS = (
    "cube",
    "turned_cube",
    "octahedron",
    "open_box",
    "drum",
    "cut_ball",
    "half_cylinder",
    "polyhedron_0",
    "polyhedron_3",
    "clamp",
    "bracket",
    "machined_1",
)
CORE_REQUESTS = (
    "poses",
    "table",
    "methods",
    "drops dull 1",
    "drops bouncy 2",
    "film",
    "sensitivity",
)
CORE = {
    name: answer
    for name, answer in ALL.items()
    if name.partition(".")[0] in CORE_PARTS and name.partition(": ")[2] in CORE_REQUESTS
}
LONG_REQUESTS = re.compile(
    "drops .* [23]|drops even 1|few|split low|catalogue|report"
    "|needle.stl: drops bouncy|(bracket|half_cylinder).stl: (auto|feeding|flips)"
)
"""Of these the long ring alone asks.

The first seed runs all the code that others do; tables are of the even scene, and the
same estimator is asked about a bouncy one. Rows of a catalogue and words of a report
are of answers that are asked for here by themselves. What is dear is asked of one part.
"""

FEW = {
    name: ALL[name]
    for name in ("cube.stl: few", "polyhedron_0.stl: few", "clamp.stl: few")
}


@pytest.fixture(scope="module")
def parts(tmp_path_factory):
    return write_parts(tmp_path_factory.mktemp("golden") / "parts")


@pytest.fixture
def in_folder_of(parts, monkeypatch):
    """Files are named in answers: as seen from the folder above them."""
    monkeypatch.chdir(parts.parent)
    return Path(parts.name)


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=[pytest.mark.long] if name.endswith(SLOW) else [])
        for name in PARTS
    ],
)
def test_answers_for_a_part(name, in_folder_of):
    file = in_folder_of / name
    if not file.exists():
        pytest.skip(f"{name} is not at hand")
    reference = {
        request: answer
        for request, answer in ALL.items()
        if request.startswith(f"{name}: ") and not LONG_REQUESTS.search(request)
    }
    assert (
        differences(answers.answers_of_part(file, reference.__contains__), reference)
        == []
    )


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize(
    "name",
    [
        pytest.param(
            name, marks=[pytest.mark.long] if LONG_REQUESTS.fullmatch(name) else []
        )
        for name in ALL
        if ": " not in name
    ],
)
def test_answers_about_several_parts(name, in_folder_of, tmp_path):
    files = sorted(file for file in in_folder_of.iterdir() if file.is_file())
    computed = answers.answers_of_commands(files, tmp_path, {name}.__contains__)
    assert differences(computed, {name: ALL[name]}) == []


def assert_kept(folder, reference, *arguments, **environment):
    """A process in another environment answers as was kept."""
    computed = answers_of(
        folder, "--only", *reference, *arguments, environment=environment
    )
    at_hand = {
        name: answer
        for name, answer in reference.items()
        if name in computed or not (folder / "parts" / "real").exists()
    }
    assert differences(computed, at_hand) == []


@pytest.mark.parametrize("machine", OLDEST)
def test_on_another_machine_with_another_hull(machine, tmp_path):
    """The long ring asks for everything, on all of them, and the hull by itself."""
    assert_kept(tmp_path, CORE, "--other-hull", **MACHINES[machine])


@pytest.mark.long
def test_with_another_hull(tmp_path):
    assert_kept(tmp_path, CORE, "--other-hull")


def test_with_kernels_run_by_python(tmp_path):
    """Python fuses no multiplication with an addition and reorders nothing: nor did
    LLVM.
    """
    assert_kept(tmp_path, FEW, NUMBA_DISABLE_JIT="1")


@pytest.mark.long
def test_with_kernels_compiled_otherwise(tmp_path):
    assert_kept(
        tmp_path,
        CORE,
        **COMPILED_OTHERWISE,
        NUMBA_CACHE_DIR=str(tmp_path / "cache"),
    )


@pytest.mark.long
@pytest.mark.parametrize("machine", MACHINES)
def test_everything_on_another_machine(machine, tmp_path):
    computed = answers_of(tmp_path, environment=MACHINES[machine])
    assert differences(computed, {name: ALL[name] for name in computed}) == []
    assert computed.keys() >= {
        name for name in ALL if not (tmp_path / "parts" / "real").exists()
    }
