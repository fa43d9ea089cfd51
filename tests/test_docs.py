"""The documents say what is true: their code runs and nothing is left out."""

import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

from ros_pose_stats.cli import parser
from ros_pose_stats.commands.outlines import outline_command
from ros_pose_stats.estimators import ESTIMATORS
from tests import commands_page

ROOT = Path(__file__).resolve().parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")


STUDY = ("dataset", "benchmark")
"""Commands whose lines go on from each other's files."""


def blocks(language: str) -> list[str]:
    return re.findall(rf"```{language}\n(.*?)```", README, re.DOTALL)


@pytest.fixture(scope="module")
def demo_directory(tmp_path_factory):
    directory = tmp_path_factory.mktemp("readme")
    command = [sys.executable, "-m", "ros_pose_stats", "shapes", "demo"]
    subprocess.run(command, cwd=directory, check=True, stdout=subprocess.DEVNULL)
    return directory


def shell_lines() -> list[str]:
    lines = [line for block in blocks("sh") for line in block.splitlines()]
    return [line for line in lines if line.startswith("ros_pose_stats")]


def lines_of(*commands: str) -> list[str]:
    return [line for line in shell_lines() if line.split()[1] in commands]


def lines_without_ros() -> list[str]:
    others = lines_of("node", "publish", "bag", *STUDY)
    return [line for line in shell_lines() if line not in others]


def test_readme_has_code_to_run():
    assert len(shell_lines()) >= 4
    assert blocks("python")


@pytest.mark.parametrize("line", lines_without_ros())
def test_shell_lines_of_the_readme_run(line, demo_directory):
    run_line(line, demo_directory)


@pytest.mark.long
def test_study_lines_of_the_readme_run(tmp_path):
    lines = lines_of(*STUDY)
    assert {line.split()[1] for line in lines} == set(STUDY)
    for line in lines:
        run_line(line, tmp_path)


def run_line(line, directory):
    command = [sys.executable, "-m", *shlex.split(line)]
    done = subprocess.run(command, cwd=directory, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stdout


@pytest.mark.parametrize("code", blocks("python"))
def test_python_of_the_readme_runs(code, demo_directory):
    done = subprocess.run([sys.executable, "-c", code], cwd=demo_directory, capture_output=True,
                          text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stdout


def test_every_method_is_in_the_readme():
    for name in ESTIMATORS:
        assert f"| `{name}` |" in README


def test_the_page_of_the_commands_is_what_the_parsers_say():
    assert commands_page.PAGE.read_text(encoding="utf-8") == commands_page.commands_page(
        outline_command(parser())), "write it again: python -m tests.commands_page"


def test_every_command_and_option_has_its_place_in_the_page_of_the_commands():
    """Read from the parsers without the outlines of which the page is made."""
    page = commands_page.PAGE.read_text(encoding="utf-8")
    sections = dict(re.findall(r"^##+ (.*)\n((?:(?!##).*\n)*)", page, re.MULTILINE))
    (commands,) = (action for action in parser()._actions if action.dest == "command")
    (kinds,) = (action for action in commands.choices["benchmark"]._actions
                if action.dest == "kind")
    found = {**commands.choices,
             **{f"benchmark {name}": kind for name, kind in kinds.choices.items()}}
    assert "estimate" in found and "benchmark table" in found
    assert found.keys() <= sections.keys()
    for name, command in found.items():
        assert f"ros_pose_stats {name}" in sections[name]
        for action in command._actions:
            for option in action.option_strings:
                if option not in ("-h", "--help"):
                    assert re.search(rf"^\| .*`{option}[ `]", sections[name],
                                     re.MULTILINE), f"{name} {option}"


def test_command_lists_the_registered_methods():
    from ros_pose_stats.commands.estimate import DEFAULT_METHOD, METHODS

    assert list(METHODS) == list(ESTIMATORS)
    assert DEFAULT_METHOD == "auto"


def test_every_warning_code_is_explained_and_every_explained_one_exists():
    sources = "".join(path.read_text(encoding="utf-8")
                      for path in (ROOT / "ros_pose_stats").rglob("*.py"))
    raised = set(re.findall(r'"([A-Z][A-Z_]{4,}): ', sources))
    explained = set(re.findall(r"^\| `([A-Z_]+)` \|",
                               (ROOT / "docs/warnings.md").read_text(encoding="utf-8"),
                               re.MULTILINE))
    assert raised
    assert raised == explained


def test_version_stands_in_one_place():
    from ros_pose_stats.version import VERSION

    assert f"<version>{VERSION}</version>" in (ROOT / "package.xml").read_text(encoding="utf-8")


def test_documents_name_files_that_exist():
    for document in [ROOT / "README.md", *(ROOT / "docs").glob("*.md")]:
        text = document.read_text(encoding="utf-8")
        for target in re.findall(r"\]\(([^)#:]+)\)", text):
            assert (document.parent / target).exists(), f"{document.name}: {target}"


def test_every_parameter_of_the_node_is_in_its_page_and_in_the_example_file():
    from ros_pose_stats.ros.settings import TABLE

    page = (ROOT / "docs/node.md").read_text(encoding="utf-8")
    example = yaml.safe_load((ROOT / "config/pose_stats.yaml").read_text(encoding="utf-8"))
    values = example["/**"]["ros__parameters"]
    assert set(values) == {setting.name for setting in TABLE} - {"mesh_topics"}
    for setting in TABLE:
        default = setting.default
        shown = str(default).lower() if isinstance(default, bool) else str(default) or "''"
        assert f"| `{setting.name}` | `{shown}` | {setting.description}" in page
        if setting.name in values:
            assert values[setting.name] == default
            assert type(values[setting.name]) is type(default)


def test_every_interface_is_in_the_page_of_the_node():
    page = (ROOT / "docs/node.md").read_text(encoding="utf-8")
    for file in (ROOT / "msg_defs").rglob("*.srv"):
        assert f"| `{file.stem}` |" in page
    for name in ("PartMesh", "PoseStatistics", "SimulateDrops"):
        assert f"`{name}`" in page
