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

"""The documents say what is true: their code runs and nothing is left out."""

import ast
import contextlib
import importlib
import io
import re
import shlex

import pytest
from catkin_pkg.changelog import Changelog, populate_changelog_from_rst
from catkin_pkg.cli.tag_changelog import rename_section
from matplotlib.image import imread

from ros_pose_stats import __version__
from ros_pose_stats.base.methods import METHODS
from ros_pose_stats.core.records.notes import ACTS
from ros_pose_stats.tools.cli import main, parser
from ros_pose_stats.tools.report.words import WORDS
from study.__main__ import main as study
from tests.house import commands_page
from tests.running import ROOT, call

README = "README.md"
COMMAND_LINE = "docs/command_line.md"
DESIGN = "docs/design.md"
PAGES = (
    README,
    COMMAND_LINE,
    "docs/library.md",
    "docs/report.md",
    "docs/catalogue.md",
    DESIGN,
)
"""Whose lines and code are run here; the tests of the node run those of its pages."""

PROGRAMS = {"ros_pose_stats": main, "python -m study": study}
ROS = ("node", "publish", "show", "bag")

DRAWN_BY = re.compile(rb"Matplotlib version[\d.]+")
"""In a picture; other versions draw the same figure a little otherwise."""

LAST_LINE = "computed in "
"""Of an answer: how long it took, which differs from run to run."""

DEAR = re.compile(
    r"\.gif|--png| catalogue | compare | flips | --suggest | --target | 20000 "
)
"""Lines that take seconds: the quick ring asks only whether the parsers take them.

Their commands are tested in `tests/contract/commands`.
"""


def text_of(page):
    return (ROOT / page).read_text(encoding="utf-8")


def blocks(page, language):
    return re.findall(rf"```{language}\n(.*?)```", text_of(page), re.DOTALL)


def lines_of(program, *pages):
    """Lines that call a program, each once."""
    return list(
        dict.fromkeys(
            line
            for page in pages
            for block in blocks(page, "sh")
            for line in block.splitlines()
            if line.startswith(program)
        )
    )


def run_line(line):
    program = next(name for name in PROGRAMS if line.startswith(name))
    outcome = call(*shlex.split(line.removeprefix(program)), program=PROGRAMS[program])
    assert outcome.returncode == 0, outcome.stderr
    assert outcome.stdout
    return outcome.stdout


@pytest.fixture(scope="module")
def demo_folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("readme")
    assert call("shapes", folder / "demo").returncode == 0
    return folder


@pytest.fixture
def in_demo_folder(demo_folder, monkeypatch):
    monkeypatch.chdir(demo_folder)
    return demo_folder


ENDLESS = re.compile(r" --watch\b")
"""Lines that go on until Ctrl-C: tests/contract/pages runs such a command."""


def runs_here(line):
    return line.split()[1] not in ROS and not ENDLESS.search(line)


LINES = [line for line in lines_of("ros_pose_stats", *PAGES) if runs_here(line)]
EXAMPLES = [
    line
    for line in lines_of("ros_pose_stats", *(ROOT / "docs").glob("*.md"))
    if line not in LINES
]
"""Of all other pages, with the help of every command."""
CODE = [code for page in PAGES for code in blocks(page, "python")]


def test_pages_have_lines_and_code_to_run():
    assert {line.split()[1] for line in LINES} >= {
        "shapes",
        "estimate",
        "simulate",
        "catalogue",
        "flips",
        "report",
        "animate",
        "compare",
        "sensitivity",
    }
    assert CODE


def test_readme_takes_two_minutes():
    assert len(text_of(README).splitlines()) <= 140


def test_answer_in_the_readme_is_what_the_command_prints(in_demo_folder):
    """To an output that takes the bars of the table."""
    (example,) = blocks(README, "text")
    (line,) = (
        line for line in lines_of("ros_pose_stats", README) if " estimate " in line
    )
    stream = io.TextIOWrapper(io.BytesIO(), encoding="utf-8")
    with contextlib.redirect_stdout(stream):
        assert main(shlex.split(line)[1:]) == 0
    printed = stream.buffer.getvalue().decode().splitlines()
    *answer, seconds = example.splitlines()
    assert answer == printed[:-1]
    assert seconds.startswith(LAST_LINE) and printed[-1].startswith(LAST_LINE)


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize(
    "line",
    [
        pytest.param(
            line,
            marks=pytest.mark.long if DEAR.search(line) else (),
        )
        for line in LINES
    ],
)
def test_lines_of_the_pages_run(line, in_demo_folder):
    run_line(line)


def test_the_parsers_take_every_example():
    """Those too that need a cell or what was counted there, or a while."""
    assert {line.split()[1] for line in EXAMPLES} >= {"bag", "fit", "node", "publish"}
    for line in (*LINES, *EXAMPLES):
        ours, _, _ = line.partition("--ros-args")
        assert parser().parse_args(shlex.split(ours)[1:]).command == line.split()[1]


@pytest.mark.long
@pytest.mark.filterwarnings("ignore")
def test_examples_run(in_demo_folder):
    for line in EXAMPLES:
        if runs_here(line) and line.split()[1] != "fit":
            run_line(line)


@pytest.mark.long
@pytest.mark.filterwarnings("ignore")
def test_lines_of_the_study_run(tmp_path, monkeypatch):
    """Later ones go on from the files of earlier ones."""
    monkeypatch.chdir(tmp_path)
    lines = lines_of("python -m study", COMMAND_LINE)
    assert lines
    for line in lines:
        run_line(line)


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("code", CODE)
def test_python_of_the_pages_runs(code, in_demo_folder):
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        exec(compile(code, "page", "exec"), {"__name__": "__main__"})
    pictures = re.findall(r'savefig\("([^"]+)"\)', code)
    assert printed.getvalue() or pictures
    for file in pictures:
        picture = in_demo_folder / file
        kept_picture = ROOT / "docs/figures" / file
        assert imread(picture).std() > 0.0
        if (
            kept_picture.exists()
            and DRAWN_BY.search(kept_picture.read_bytes())[0] in picture.read_bytes()
        ):
            # The ink of a digit is 8e-5 of such a figure.
            assert abs(imread(picture) - imread(kept_picture)).mean() < 2e-5


def test_every_method_is_in_its_page():
    page = text_of("docs/methods.md")
    for method in METHODS:
        assert (
            f"| `{method.name}` | {method.about} |"
            if method.module
            else f"`{method.name}`"
        ) in page


def test_the_page_of_the_commands_is_what_the_parsers_say():
    assert commands_page.PAGE.read_text(
        encoding="utf-8"
    ) == commands_page.commands_page(parser()), (
        "write it again: python -m tests.house.commands_page"
    )


def test_every_argument_is_explained():
    page = commands_page.PAGE.read_text(encoding="utf-8")
    rows = [line for line in page.splitlines() if line.startswith("| `")]
    assert rows and not [
        row for row in rows if len(row.split(" | ")[-1].strip("| ")) < 5
    ]


def test_every_command_and_option_has_its_place_in_the_page_of_the_commands():
    """Read from the parsers without the page."""
    page = commands_page.PAGE.read_text(encoding="utf-8")
    sections = dict(re.findall(r"^##+ (.*)\n((?:(?!##).*\n)*)", page, re.MULTILINE))
    (commands,) = (action for action in parser()._actions if action.dest == "command")
    assert "estimate" in commands.choices and commands.choices.keys() <= sections.keys()
    for name, command in commands.choices.items():
        assert f"ros_pose_stats {name}" in sections[name]
        for action in command._actions:
            for option in action.option_strings:
                if option not in ("-h", "--help"):
                    assert re.search(
                        rf"^\| .*`{option}[ `]", sections[name], re.MULTILINE
                    ), f"{name} {option}"


def test_every_warning_code_is_explained_and_every_explained_one_exists():
    """With whether somebody should act; pages have words for all of them."""
    sources = "".join(
        path.read_text(encoding="utf-8")
        for path in (ROOT / "ros_pose_stats").rglob("*.py")
    )
    raised = set(re.findall(r'\bnote\(\s*"([A-Z_]+)"', sources))
    explained = re.findall(
        r"^\| `([A-Z_]+)` \| (yes|no) \| .+ \|$",
        (ROOT / "docs/warnings.md").read_text(encoding="utf-8"),
        re.MULTILINE,
    )
    assert {code: acts == "yes" for code, acts in explained} == ACTS
    assert raised == ACTS.keys() == WORDS.keys()


def test_version_stands_in_one_place():
    assert f"<version>{__version__}</version>" in text_of("package.xml")


@pytest.mark.filterwarnings("ignore")  # of docutils
@pytest.mark.parametrize("folder", [".", "msg_defs"])
def test_the_changelogs_are_what_a_release_takes(folder):
    """What has no version yet becomes the next one; the present one is there
    already.
    """
    released = rename_section(
        text_of(f"{folder}/CHANGELOG.rst"), "Forthcoming", "99.0.0 (2026-01-01)"
    )
    changelog = Changelog()
    populate_changelog_from_rst(changelog, released)
    versions = {version for version, *_ in changelog.foreach_version()}
    assert {"99.0.0", __version__} <= versions


def test_documents_name_files_that_exist():
    for document in [ROOT / "README.md", *(ROOT / "docs").rglob("*.md")]:
        text = document.read_text(encoding="utf-8")
        for target in re.findall(r"\]\(([^)#:]+)\)", text):
            assert (document.parent / target).exists(), f"{document.name}: {target}"


def anchor_of(heading):
    """The end of a link to a heading, as GitHub makes it."""
    return re.sub(r"[^\w\- ]", "", heading.strip().lower()).replace(" ", "-")


def test_links_into_pages_name_headings_that_exist():
    links = 0
    for document in [ROOT / "README.md", *(ROOT / "docs").rglob("*.md")]:
        text = document.read_text(encoding="utf-8")
        for target, anchor in re.findall(r"\]\(([^)#:\s]*)#([^)\s]+)\)", text):
            page = (
                (document.parent / target).read_text(encoding="utf-8")
                if target
                else text
            )
            headings = re.findall(r"^#+ (.*)$", page, re.MULTILINE)
            assert anchor in map(anchor_of, headings), (
                f"{document.name}: {target}#{anchor}"
            )
            links += 1
    assert links > 20


def test_no_two_pages_have_one_title():
    titles = [
        page.read_text(encoding="utf-8").splitlines()[0]
        for page in (ROOT / "docs").rglob("*.md")
    ]
    assert len(set(titles)) == len(titles)


def test_every_decision_has_a_room_a_date_and_a_state():
    page = (ROOT / "docs/decisions.md").read_text(encoding="utf-8")
    rooms = re.split(r"^## ", page, flags=re.MULTILINE)[1:]
    for room in rooms:
        title, *paragraphs = room.strip().split("\n\n")
        decisions = [
            paragraph for paragraph in paragraphs if not paragraph.startswith("- ")
        ]
        assert decisions, title
        for decision in decisions:
            assert re.match(
                r"\*\*[^*]+\*\* \(20\d\d-\d\d-\d\d, (holds|replaced by) ?",
                decision.replace("\n", " "),
            ), f"{title}: {decision}"


def test_decisions_name_files_that_exist():
    page = (ROOT / "docs/decisions.md").read_text(encoding="utf-8")
    files = re.findall(r"`((?:\w+/)*\w+\.py)`", page)
    assert files
    for file in files:
        assert (ROOT / file).exists() or (ROOT / "ros_pose_stats" / file).exists(), file


def test_scripts_outside_the_package_import_what_is_there():
    for file in (*(ROOT / ".ci").glob("*.py"), *(ROOT / "launch").glob("*.py")):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom) and node.module.startswith(
                "ros_pose_stats."
            ):
                module = importlib.import_module(node.module)
                assert all(hasattr(module, alias.name) for alias in node.names), (
                    ast.unparse(node)
                )
