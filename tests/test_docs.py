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
from ros_pose_stats.methods import METHODS
from tests import commands_page

ROOT = Path(__file__).resolve().parents[1]
README = "README.md"
COMMAND_LINE = "docs/command_line.md"
LIBRARY = "docs/library.md"
REPORT = "docs/report.md"
CATALOGUE = "docs/catalogue.md"
DESIGN = "docs/design.md"
SENSITIVITY = "docs/sensitivity.md"
PAGES = (README, COMMAND_LINE, LIBRARY, REPORT, CATALOGUE, DESIGN, SENSITIVITY)
"""Whose lines and code are run here; `tests/ros` runs those of the node."""

STUDY = ("dataset", "benchmark")
"""Commands whose lines go on from each other's files."""

LAST_LINE = "computed in "
"""Of an answer: how long it took, which differs from run to run."""


def text_of(page: str) -> str:
    return (ROOT / page).read_text(encoding="utf-8")


def blocks(page: str, language: str) -> list[str]:
    return re.findall(rf"```{language}\n(.*?)```", text_of(page), re.DOTALL)


@pytest.fixture(scope="module")
def demo_directory(tmp_path_factory):
    directory = tmp_path_factory.mktemp("readme")
    command = [sys.executable, "-m", "ros_pose_stats", "shapes", "demo"]
    subprocess.run(command, cwd=directory, check=True, stdout=subprocess.DEVNULL)
    return directory


def shell_lines(page: str) -> list[str]:
    lines = [line for block in blocks(page, "sh") for line in block.splitlines()]
    return [line for line in lines if line.startswith("ros_pose_stats")]


def lines_of(page: str, *commands: str) -> list[str]:
    return [line for line in shell_lines(page) if line.split()[1] in commands]


def lines_without_ros() -> list[str]:
    """Lines of all pages, each once."""
    lines = dict.fromkeys(line for page in PAGES for line in shell_lines(page))
    return [line for line in lines
            if line.split()[1] not in ("node", "publish", "bag", *STUDY)]


def code_of_the_pages() -> list[str]:
    return [code for page in PAGES for code in blocks(page, "python")]


def test_pages_have_code_to_run():
    assert len(shell_lines(README)) == 5
    assert len(shell_lines(COMMAND_LINE)) == 12
    assert len(blocks(README, "python")) == 1
    assert len(blocks(LIBRARY, "python")) == 6
    assert len(blocks(SENSITIVITY, "python")) == 2
    commands = {line.split()[1] for line in lines_without_ros()}
    assert commands == {"shapes", "estimate", "simulate", "catalogue", "flips", "report",
                        "animate", "compare", "sensitivity"}


def test_readme_takes_two_minutes():
    assert len(text_of(README).splitlines()) <= 120


def test_answer_in_the_readme_is_what_the_command_prints(demo_directory):
    (shown,) = blocks(README, "text")
    (line,) = lines_of(README, "estimate")
    printed = run_line(line, demo_directory).splitlines()
    *answer, seconds = shown.splitlines()
    assert answer == printed[:-1]
    assert seconds.startswith(LAST_LINE) and printed[-1].startswith(LAST_LINE)


@pytest.mark.parametrize("line", [
    pytest.param(line, marks=pytest.mark.long if line.endswith(".gif") else ())
    for line in lines_without_ros()])
def test_shell_lines_of_the_pages_run(line, demo_directory):
    run_line(line, demo_directory)


@pytest.mark.long
def test_study_lines_run(tmp_path):
    lines = lines_of(COMMAND_LINE, *STUDY)
    assert {line.split()[1] for line in lines} == set(STUDY)
    for line in lines:
        run_line(line, tmp_path)


def run_line(line, directory):
    command = [sys.executable, "-m", *shlex.split(line)]
    done = subprocess.run(command, cwd=directory, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stdout
    return done.stdout


@pytest.mark.parametrize("code", code_of_the_pages())
def test_python_of_the_pages_runs(code, demo_directory):
    done = subprocess.run([sys.executable, "-c", code], cwd=demo_directory, capture_output=True,
                          text=True, check=False)
    assert done.returncode == 0, done.stderr
    drawn = re.findall(r'savefig\("([^"]+)"\)', code)
    assert done.stdout or drawn
    assert all((demo_directory / file).stat().st_size > 0 for file in drawn)


def test_every_method_is_in_its_page():
    page = text_of("docs/methods.md")
    for one in METHODS:
        assert (f"| `{one.name}` | {one.about} |" if one.module else f"`{one.name}`") in page


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
    for document in [ROOT / "README.md", *(ROOT / "docs").rglob("*.md")]:
        text = document.read_text(encoding="utf-8")
        for target in re.findall(r"\]\(([^)#:]+)\)", text):
            assert (document.parent / target).exists(), f"{document.name}: {target}"


def test_no_two_pages_have_one_title():
    titles = [page.read_text(encoding="utf-8").splitlines()[0]
              for page in (ROOT / "docs").rglob("*.md")]
    assert len(set(titles)) == len(titles)


def test_the_page_on_sensitivity_has_the_figures_of_the_study():
    study = (ROOT / "docs/study/design.md").read_text(encoding="utf-8")
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in study.splitlines()
            if line.startswith("|")]
    table = {row[0]: row[1:] for row in rows}
    cases, clear, right, _, size, apart, _ = table["edge chamfered"]
    others = [int(table[name][2]) for name in ("centre of mass", "stretching", "resting face")]
    page = " ".join(text_of(SENSITIVITY).split())
    for words in (f"{clear} of {cases} changes by a cut edge",
                  f"these {right} % had the right sign",
                  f"{min(others)} to {max(others)} % for all other",
                  f"{size} points, and the estimate was off by {apart}"):
        assert words in page, words


def test_the_page_of_the_node_shows_the_table_of_parameters():
    from tests.parameters_table import PAGE, parameters_table

    assert PAGE.read_text(encoding="utf-8").endswith(parameters_table()), \
        "write it again: python -m tests.parameters_table"


def test_the_example_file_has_every_parameter_with_its_default():
    from ros_pose_stats.ros.settings import TABLE

    example = yaml.safe_load((ROOT / "config/pose_stats.yaml").read_text(encoding="utf-8"))
    values = example["/**"]["ros__parameters"]
    assert set(values) == {setting.name for setting in TABLE} - {"mesh_topics"}
    for setting in TABLE:
        if setting.name in values:
            assert values[setting.name] == setting.default
            assert type(values[setting.name]) is type(setting.default)


def test_every_interface_is_in_the_page_of_the_node():
    page = (ROOT / "docs/node.md").read_text(encoding="utf-8")
    for file in (ROOT / "msg_defs").rglob("*.srv"):
        assert f"| `{file.stem}` |" in page
    for name in ("PartMesh", "PoseStatistics", "ObservedParts", "SimulateDrops"):
        assert f"`{name}`" in page


def test_every_decision_has_a_room_a_date_and_a_state():
    page = (ROOT / "docs/decisions.md").read_text(encoding="utf-8")
    rooms = re.split(r"^## ", page, flags=re.MULTILINE)[1:]
    assert len(rooms) == 15
    for room in rooms:
        title, *paragraphs = room.strip().split("\n\n")
        decisions = [one for one in paragraphs if not one.startswith("- ")]
        assert decisions, title
        for one in decisions:
            assert re.match(r"\*\*[^*]+\*\* \(20\d\d-\d\d-\d\d, (holds|replaced by) ?",
                            one.replace("\n", " ")), f"{title}: {one}"


def test_decisions_name_files_that_exist():
    page = (ROOT / "docs/decisions.md").read_text(encoding="utf-8")
    named = re.findall(r"`((?:\w+/)*\w+\.py)`", page)
    assert len(named) >= 8
    for file in named:
        assert (ROOT / file).exists() or (ROOT / "ros_pose_stats" / file).exists(), file
