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

"""What README and docs/node.md say of the node, and tell a reader to type, is so."""

import contextlib
import io
import os
import re
import shlex
import signal
import subprocess
import sys
from pathlib import Path
from shutil import which
from unittest import mock

import pytest
import ros_pose_stats_msgs
import yaml

# Sets discovery and checks, before ROS is imported.
import tests.contract.node.conftest  # noqa: F401
from tests.contract.node.contract import (
    ACTION,
    CODES,
    DEFAULTS,
    FIXED,
    PUBLICATIONS,
    SUBSCRIPTIONS,
)
from tests.contract.node.harness.cell import latched
from tests.contract.node.harness.client import Client, until
from tests.contract.node.harness.domains import own_domain
from tests.contract.node.harness.node import PATIENCE
from tests.running import ROOT, answer, call

PAGE = (ROOT / "docs/node.md").read_text(encoding="utf-8")
CODE = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)
INCLUDE = Path(sys.prefix, "include")
README = (ROOT / "README.md").read_text(encoding="utf-8")
LINES = [
    line
    for block in re.findall(r"```sh\n(.*?)```", README, re.DOTALL)
    for line in block.splitlines()
]


def line_of(command):
    """What the README says to type, without the name of the program."""
    [line] = [line for line in LINES if line.startswith(f"ros_pose_stats {command}")]
    return shlex.split(line)[1:]


@pytest.fixture(scope="module")
def domain(tmp_path_factory):
    with (
        own_domain() as number,
        mock.patch.dict(
            os.environ,
            {
                "ROS_DOMAIN_ID": str(number),
                "ROS_LOG_DIR": str(tmp_path_factory.mktemp("logs")),
            },
        ),
    ):
        yield number


@pytest.fixture(scope="module")
def home(domain, tmp_path_factory):
    """Where the README's lines go on until Ctrl-C."""
    home = tmp_path_factory.mktemp("cell")
    answer("shapes", home / "demo")
    folders = f"mesh_folders:=[{home / 'demo'}]"  # of the page's planner
    node = subprocess.Popen(
        [
            *(sys.executable, "-m", "ros_pose_stats", *line_of("node")),
            *("--ros-args", "-p", folders),
        ],
        cwd=home,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    )
    yield home
    node.send_signal(signal.SIGINT)
    log = node.communicate(timeout=PATIENCE)[1]
    assert node.returncode == 0 and "Traceback" not in log, log


@pytest.fixture(scope="module")
def client(home, domain):
    """A client of the README's node."""
    with Client(domain) as client:
        yield client


@pytest.fixture(scope="module")
def published(home, client):
    """What the README's second terminal says of its part."""
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(home)
        table = call(*line_of("publish")).stdout
    until(lambda: latched(client, "clamp").drops, "its check")
    return table, until(lambda: call(*line_of("show")).stdout, "an answer in time")


def test_the_readme_shows_what_the_second_terminal_says(published):
    table, row = published
    assert f"```\n{row}```\n" in README
    assert "stable poses, 968 triangles" in table and table.count("clamp: ") == 2


def test_the_readme_s_bag_shows_the_published_part(published, home, monkeypatch):
    monkeypatch.chdir(home)
    until(
        lambda: re.search("clamp.*split", answer(*line_of("bag")), re.DOTALL),
        "both in the bag",
    )


@pytest.mark.parametrize("code", CODE)
def test_the_page_s_planner_runs(published, home, code):
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        exec(code.replace("/cad/", f"{home}/demo/"), {"__name__": "__main__"})
    # Its two flats are next to equally probable: drops may put either first.
    assert re.search("clamp/[01]", printed.getvalue())
    assert "expected error" in printed.getvalue()
    assert "PlanFeeding" not in code or "clamp: pick [" in printed.getvalue()


@pytest.mark.skipif(
    not (INCLUDE / "ros_pose_stats_msgs").is_dir() or which("g++") is None,
    reason="no headers of messages, or no compiler",
)
def test_the_page_s_messages_compile_in_cpp(tmp_path):
    [code] = re.findall(r"```cpp\n(.*?)```", PAGE, re.DOTALL)
    assert len(code.splitlines()) <= 30
    file = tmp_path / "planner.cpp"
    file.write_text(code)
    folders = [f"-I{path}" for path in INCLUDE.iterdir()]
    outcome = subprocess.run(
        ["g++", "-std=c++17", "-fsyntax-only", *folders, file],
        capture_output=True,
        text=True,
    )
    assert outcome.returncode == 0, outcome.stderr


def test_the_page_s_table_is_what_the_node_says_of_its_parameters(client):
    rows = dict(
        re.findall(
            r"^\| `(\w+)` \| `(.*?)` \| .* \|$",
            PAGE.split("## Parameters")[1],
            re.MULTILINE,
        )
    )
    assert rows == {
        name: str(value).lower() if isinstance(value, bool) else str(value) or "''"
        for name, value in DEFAULTS.items()
    }
    for described in client.call(
        "describe_parameters", names=list(DEFAULTS)
    ).descriptors:
        fixed = " Set at the start only." if described.name in FIXED else ""
        assert f" | {described.description}{fixed} |\n" in PAGE, described.name


def test_the_page_s_table_of_codes_is_that_of_the_contract():
    rows = re.findall(r"^\| (\d+) \| `([A-Z_]+)` \| .+ \|$", PAGE, re.MULTILINE)
    assert {name: int(number) for number, name in rows} == CODES


def test_the_example_file_has_every_parameter_with_its_default():
    example = yaml.safe_load(
        (ROOT / "config/pose_stats.yaml").read_text(encoding="utf-8")
    )
    values = example["/**"]["ros__parameters"]
    assert set(values) == set(DEFAULTS) - {"mesh_topics", "mesh_folders"}
    for name, value in values.items():
        assert value == DEFAULTS[name] and type(value) is type(DEFAULTS[name]), name


def test_the_page_names_every_topic_and_installed_interface():
    share = (
        next(
            path
            for path in Path(ros_pose_stats_msgs.__file__).parents
            if (path / "share/ros_pose_stats_msgs").is_dir()
        )
        / "share/ros_pose_stats_msgs"
    )
    services = {file.stem for file in share.glob("srv/*.srv")}
    assert services and all(f"| `{name}` |" in PAGE for name in services)
    topics = {
        name.replace("/pose_stats/", "~/"): kind
        for name, kind in {**SUBSCRIPTIONS, **PUBLICATIONS, **ACTION}.items()
    }
    for name, kind in topics.items():
        assert f"`{name}`" in PAGE, name
        assert kind.rpartition("/")[2] in PAGE, kind
