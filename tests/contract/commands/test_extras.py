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

"""Without the modules of an extra: what needs one is refused in a line, all else
runs.
"""

import json
import subprocess
import sys

import pytest

from tests.contract.bags.recorders import write_recorded
from tests.running import ROOT

WITHOUT_TOOLS = """
import contextlib, io, json, pkgutil, sys
from importlib import import_module

class Blocker:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in ("matplotlib", "PIL", "jinja2", "shtab"):
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)

sys.meta_path.insert(0, Blocker())
from ros_pose_stats import node
from ros_pose_stats.tools import cli

ends = {}
for name, words in json.loads(sys.argv[1]).items():
    out = io.StringIO()
    err = io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            status = cli.main(words)
        except SystemExit as end:
            status = end.code
    ends[name] = status, len(out.getvalue()), err.getvalue()
try:
    import rclpy
    modules = list(pkgutil.walk_packages(node.__path__, f"{node.__name__}."))
    for module in modules:
        import_module(module.name)
    ends["node"] = 0, len(modules), ""
except ModuleNotFoundError as error:
    if error.name != "rclpy":
        raise
print(json.dumps(ends))
"""

WITHOUT_ITS_NEEDS = """
import sys
missing, *words = sys.argv[1:]
sys.modules[missing] = None
from ros_pose_stats.node import entry
from ros_pose_stats.tools import cli
sys.argv = [sys.argv[0], *words[1:]]
sys.exit(entry.main() if words[0] == "pose_stats_node" else cli.main(words))
"""

TOOLS = "pip install 'ros_pose_stats[tools]'"


@pytest.fixture(scope="module")
def ends(parts, tmp_path_factory):
    """By command: how it ended in one process that lacks all modules of `tools`."""
    folder = tmp_path_factory.mktemp("without")
    part = [str(parts / "box.stl"), "--unit", "mm"]
    lines = {
        "help": ["--help"],
        "estimate": ["estimate", *part],
        "simulate": ["simulate", *part, "--drops", "20"],
        "bag": ["bag", str(write_recorded(folder / "bag"))],
        "film": ["animate", *part, "-o", str(folder / "a.mcap")],
        "animate": ["animate", *part, "-o", str(folder / "a.gif")],
        "report": ["report", *part, "-o", str(folder / "a.html")],
        "compare": ["compare", part[0], *part, "-o", str(folder / "a.html")],
        "catalogue": ["catalogue", *part, "-o", str(folder / "quotes")],
        "png": ["sensitivity", *part, "--wanted", "0", "--png", str(folder / "a.png")],
        "completion": ["completion", "bash"],
    }
    process = subprocess.run(
        [sys.executable, "-c", WITHOUT_TOOLS, json.dumps(lines)],
        capture_output=True,
        text=True,
        cwd=ROOT,
    )
    assert process.returncode == 0, process.stderr
    return json.loads(process.stdout.splitlines()[-1])


@pytest.mark.parametrize("command", ["help", "estimate", "simulate", "bag", "film"])
def test_what_needs_no_pictures_runs_without_the_extra(ends, command):
    status, length, _ = ends[command]
    assert status == 0 and length > 0


def test_the_whole_node_is_imported_without_the_extra(ends):
    if "node" not in ends:
        pytest.skip("there is no ROS here")
    assert ends["node"][1] > 30


@pytest.mark.parametrize(
    ("command", "module", "purpose"),
    [
        ("animate", "matplotlib", "draws pictures"),
        ("report", "jinja2", "writes pages"),
        ("compare", "jinja2", "writes pages"),
        ("catalogue", "jinja2", "writes pages"),
        ("png", "matplotlib", "draws pictures"),
        ("completion", "shtab", "writes what Tab completes"),
    ],
)
def test_what_needs_the_extra_is_refused_with_the_remedy(
    ends, command, module, purpose
):
    status, length, error = ends[command]
    (line,) = [line for line in error.splitlines() if "compiling kernels" not in line]
    assert (status, length) == (2, 0)
    assert f"the module {module}, which {purpose}, got none" in line
    assert line.endswith(f"`{TOOLS}`")


def test_a_picture_of_the_library_is_refused_alike():
    code = (
        "import sys; sys.modules['matplotlib'] = None\n"
        "from ros_pose_stats import PoseStatsError\n"
        "try:\n    from ros_pose_stats.tools.plots.poses import poses_figure\n"
        "except PoseStatsError as refusal:\n    print(refusal)"
    )
    process = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, cwd=ROOT
    )
    assert "the module matplotlib" in process.stdout and TOOLS in process.stdout


@pytest.mark.parametrize(
    ("module", "words", "remedy"),
    [
        ("numba", ["estimate"], "-m pip install numba`"),
        ("mcap", ["bag"], "-m pip install mcap`"),
        ("mcap", ["pose_stats_node"], "-m pip install mcap`"),
        ("ros_pose_stats_msgs.msg", ["pose_stats_node"], "build the workspace anew"),
    ],
)
def test_a_module_that_every_user_needs_is_named_with_the_python_that_lacks_it(
    parts, tmp_path, module, words, remedy
):
    files = {
        "estimate": [str(parts / "box.stl"), "--unit", "mm"],
        "bag": [str(write_recorded(tmp_path / "bag"))],
    }
    outcome = subprocess.run(
        [
            sys.executable,
            "-c",
            WITHOUT_ITS_NEEDS,
            module,
            *words,
            *files.get(words[0], []),
        ],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert (outcome.returncode, outcome.stdout) == (2, ""), outcome.stderr
    (line,) = outcome.stderr.splitlines()
    assert line.startswith(
        f"{words[0]}: " if "node" in words[0] else "ros_pose_stats: "
    )
    assert f"expected a module {module.partition('.')[0]} that {sys.executable}" in line
    assert remedy in line
