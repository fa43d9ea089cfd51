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

"""Arguments of the commands: the parser, numbers as people type them, shared options.

A count may be typed as 1e5, poses as 0,1 or 0 1 or 0-3, a length as 0.2, 200mm or 8 in.
A refusal is one line, and every help ends with an example.
"""

import argparse
import math
import re
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from decimal import Decimal, InvalidOperation
from itertools import chain
from pathlib import Path
from typing import Any, NoReturn, TypeAlias

from ....base.errors import RequestError
from ....core.records.scene import (
    DEFAULT_CLUSTER_TOLERANCE,
    DEFAULT_RESTITUTION,
    DEFAULT_ROUND_SIDES,
    DropScene,
)

REFUSED = 2

EMPTY_VALUE = re.compile(r"(?:--[a-z-]+=|-[a-z])--")
"""An option in one word with the value `--`, from which argparse makes an empty
list."""

TABLE_ENDINGS = (".csv", ".tsv", ".txt")

Commands: TypeAlias = "argparse._SubParsersAction[CommandParser]"
"""Where a command adds its parser; argparse has no public name for it."""


class CommandParser(argparse.ArgumentParser):
    """A parser whose refusals are one line, and for whom -1e-3 and -1mm are no options.

    `examples`: whole lines as they are typed, shown at the end of the help; `run`: from
    options to the exit status.
    """

    def __init__(
        self,
        *,
        examples: Sequence[str] = (),
        run: Callable[[argparse.Namespace], int] | None = None,
        **options: Any,
    ) -> None:
        super().__init__(**options)
        self.set_defaults(run=run)
        self.advanced = self.add_argument_group("advanced options")
        self.examples = tuple(examples)
        self._negative_number_matcher = LENGTH

    def format_help(self) -> str:
        """The help, with the examples as the last lines."""
        title = "example" if len(self.examples) == 1 else "examples"
        lines = "".join(f"  {line}\n" for line in self.examples)
        return super().format_help() + (f"\n{title}:\n{lines}" if lines else "")

    def parse_known_args(
        self, args: Any = None, namespace: Any = None
    ) -> tuple[Any, list[str]]:
        """Parse; an unknown option is refused by the command that it was given to."""
        words = _split_coordinates(sys.argv[1:] if args is None else args)
        for word in words:
            if EMPTY_VALUE.fullmatch(word):
                self.error(f"expected a value in {word}, got --")
        parsed, unknown = super().parse_known_args(words, namespace)
        if unknown:
            options = re.findall(r"--[a-z-]+", super().format_help())
            suggestion = _suggestion(unknown[0].partition("=")[0], options)
            self.error(f"unrecognized arguments: {' '.join(unknown)}{suggestion}")
        return parsed, unknown

    def error(self, message: str) -> NoReturn:
        """Print one line, with the nearest choice, and exit with status 2."""
        choice = re.search(r"invalid choice: '(.*?)' \(choose from (.*)\)", message)
        if choice:
            suggestion = _suggestion(choice[1], re.findall(r"[\w-]+", choice[2]))
            if suggestion:
                message = message.replace(f" (choose from {choice[2]})", suggestion)
        self.exit(REFUSED, f"{self.prog}: {message}; see `{self.prog} --help`\n")


def _split_coordinates(words: Sequence[str]) -> list[str]:
    """The words, with coordinates apart that are one word: --com "1mm 2mm 0"."""
    split: list[str] = []
    for option, word in zip(["", *words], words, strict=False):
        if option == "--com" and not LENGTH.match(word):
            split += word.replace(",", " ").split() or [""]
        else:
            split.append(word)
    return split


def _suggestion(word: str, choices: Sequence[str]) -> str:
    """The choice that is nearest to a word, as a question; empty where none is near."""
    import difflib

    matches = difflib.get_close_matches(word, choices, 1)
    return f"; did you mean {matches[0]}?" if matches else ""


LENGTH = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*([a-zA-Z]*)\s*$")
MOST_DIGITS = 30  # digits of a whole number; no seed has more
POSES = "indices of poses, for instance 0,1 or 0 1 or 0-3"
MOST_RANGE = 100_000  # poses of a range; no part has more
MOST_REPEATED = 60  # characters of the refused text that the refusal repeats


def read_count(text: str) -> int:
    """A whole number in any range, in digits or in scientific notation."""
    try:
        number = Decimal(text)
    except InvalidOperation:
        number = Decimal("nan")
    # Before the conversion: 1e999999999 as an integer fills the memory.
    if number.is_finite() and number.adjusted() >= MOST_DIGITS:
        raise refusal(f"a whole number of at most {MOST_DIGITS} digits", text)
    if not number.is_finite() or number != number.to_integral_value():
        raise refusal("a whole number, for instance 100000 or 1e5", text)
    return int(number)


def read_body(text: str) -> int | str:
    """The number of a body, or `all`."""
    return text if text == "all" else read_count(text)


def read_length(text: str) -> float:
    """A length in metres, from a number of metres, or one with a unit behind it."""
    length = LENGTH.match(text)
    metres = None
    if length is not None:
        # numpy comes with it, and --help does without.
        from ....core.mesh.units import METRES_PER_UNIT, unit_name

        metres = METRES_PER_UNIT.get(unit_name(length[2] or "m") or "")
    if length is None or metres is None:
        raise refusal(
            "a length, for instance 0.2 for metres, 200mm, 20cm or 8inch", text
        )
    return float(length[1]) * metres


def read_pixel(text: str) -> float:
    """A length above 0."""
    metres = read_length(text)
    if not 0.0 < metres < math.inf:
        raise refusal("a length above 0, for instance 0.1mm", text)
    return metres


def read_indices(text: str) -> list[int]:
    """Indices of poses, separated by commas or spaces; 0-3 stands for 0,1,2,3."""
    pieces = [piece.split() for piece in text.strip().removesuffix(",").split(",")]
    if not all(pieces):
        raise refusal(POSES, text)
    return [
        index for piece in pieces for word in piece for index in _read_range(word, text)
    ]


def _read_range(word: str, text: str) -> Sequence[int]:
    """The indices of a number or a range, as a table or a page writes it."""
    if word.removeprefix("-").isdecimal():
        return [read_count(word)]
    begin, _, end = word.replace("\N{EN DASH}", "-").partition("-")
    if not (begin.isdecimal() and end.isdecimal()):
        raise refusal(POSES, text)
    indices = range(read_count(begin), read_count(end) + 1)
    # Before it is written out: a range may be longer than the memory.
    if not indices or indices[-1] - indices[0] >= MOST_RANGE:
        raise refusal(
            f"{POSES}; a range rises and has at most {MOST_RANGE} poses", text
        )
    return indices


class JoinIndices(argparse.Action):
    """Joins the lists that `read_indices` returned into one."""

    def __call__(
        self,
        parser: argparse.ArgumentParser,
        namespace: argparse.Namespace,
        values: str | Sequence[Any] | None,
        option_string: str | None = None,
    ) -> None:
        """Store the list."""
        setattr(namespace, self.dest, list(chain.from_iterable(values or ())))


def refusal(expected: str, text: str) -> argparse.ArgumentTypeError:
    """The error of a word that is not what an option takes."""
    if len(text) > MOST_REPEATED:
        text = f"{text[: MOST_REPEATED - 1]}…"
    return argparse.ArgumentTypeError(f"expected {expected}, got {text!r}")


UNITS = ("auto", "mm", "m", "cm", "inch")


def read_unit(text: str) -> str:
    """The name of a unit from any spelling; another word, to be refused as a choice."""
    if text in UNITS:
        return text
    # numpy and the kernels come with it, and --help does without.
    from ....core.mesh.units import unit_name

    return unit_name(text) or text


CENTER_HELP = (
    "centre of mass in the file's axes, as 0.017 (metres) or 17mm (default: uniform "
    "density)"
)
KICK_HELP = (
    "energy of a kick over the part's weight, a height as 0.003 (metres) or 3mm: as "
    "high would it throw the part without turning it"
)

OPTIONS: dict[str, dict[str, Any]] = {
    "part": {"metavar": "PART", "help": "file: STEP, STL, OBJ, PLY, OFF or 3MF"},
    "--unit": {
        "type": read_unit,
        "choices": UNITS,
        "default": UNITS[0],
        "help": "unit of the file, in any spelling (default: auto, what the file "
        "names, else m for up to 0.6 units and mm for more, with a warning)",
    },
    "--body": {
        "type": read_body,
        "metavar": "N",
        "help": "body of the file that is the part, of those that stand apart, from 0 "
        "for the largest; `all`: all as one rigid part (default: the first of equal "
        "ones; different ones are refused, with their numbers and sizes)",
    },
    "--accept-open": {
        "action": "store_true",
        "help": "take the convex hull of a solid of a STEP file whose surface comes "
        "out with holes, and tell no error (default: such a file is refused)",
    },
    "--com": {
        "nargs": 3,
        "type": read_length,
        "metavar": ("X", "Y", "Z"),
        "help": CENTER_HELP,
    },
    "--mass": {
        "type": float,
        "metavar": "KG",
        "help": "mass in kilograms (default: 1)",
    },
    "--density": {
        "type": float,
        "metavar": "KG_M3",
        "help": "density in kilograms a cubic metre, for the mass of the volume that "
        "the mesh encloses",
    },
    "--cluster-tolerance": {
        "type": float,
        "default": DEFAULT_CLUSTER_TOLERANCE,
        "metavar": "T",
        "help": "least rise of the centre of mass out of a pose, as a share of its "
        "height there; what is shallower belongs to the pose next to it (default: "
        "%(default)s; 0 lists every stable face)",
    },
    "--round-sides": {
        "type": read_count,
        "default": DEFAULT_ROUND_SIDES,
        "metavar": "N",
        "help": "sides a turn of the polygons that stand for round surfaces, whatever "
        "the file has (default: %(default)s; 0 takes the file as it is)",
    },
    "--restitution": {
        "type": float,
        "default": DEFAULT_RESTITUTION,
        "metavar": "R",
        "help": "coefficient of restitution of the plate, 0 to below 1 (default: "
        "%(default)s)",
    },
    "--drop-height": {
        "type": read_length,
        "metavar": "H",
        "help": "height of the centre of mass at release, as 0.2 (metres) or 200mm "
        "(default: 20 part radii); a part too large for it is released touching "
        "the plate",
    },
    "--wanted": {
        "type": read_indices,
        "nargs": "+",
        "action": JoinIndices,
        "metavar": "I",
        "help": "indices of the poses that are accepted, for instance 0 1 or 0-3",
    },
    "--rate": {
        "type": float,
        "default": 60.0,
        "metavar": "R",
        "help": "parts that can be dropped a minute (default: %(default)s)",
    },
    "--kick": {"type": read_length, "metavar": "H", "help": KICK_HELP},
    "--cycle-time": {
        "type": float,
        "default": 1.0,
        "metavar": "S",
        "help": "seconds from one kick to the next (default: %(default)s)",
    },
    "--drops": {"type": read_count, "metavar": "N"},
    "--flips": {
        "type": read_count,
        "metavar": "N",
        "help": "kicks out of each pose at each height (default: 10000 shared out over "
        "the poses)",
    },
    "--seed": {
        "type": read_count,
        "metavar": "S",
        "help": "the same seed gives the same counts (default: a fresh one, which the "
        "answer names; `estimate` without a target error takes 1)",
    },
    "--workers": {
        "type": read_count,
        "metavar": "W",
        "help": "number of threads (default: all cores)",
    },
    "--pixel": {
        "type": read_pixel,
        "metavar": "P",
        "help": "side of what a pixel of the camera shows of the plate, as 0.1mm: "
        "poses look alike whose silhouettes differ by no more than half a pixel along "
        "their outline (default: by no more than 1 %% of their area)",
    },
    "--output": {"metavar": "FILE"},
    "--png": {"metavar": "FILE"},
    "--each": {
        "action": "store_true",
        "help": "give every pose a row of its own; else poses that the part's symmetry "
        "makes alike share one, with their number and total",
    },
    "--json": {
        "action": "store_true",
        "help": "print one JSON object, in SI units, which its key `units` names, and "
        "no table",
    },
    "--node": {
        "default": "pose_stats",
        "metavar": "NAME",
        "help": "name of the node (default: %(default)s); relative ones are in the "
        "namespace that `--ros-args -r __ns:=/NAMESPACE` gives",
    },
}
"""What commands share."""

SHARED_UNIT_HELP = (
    "unit of the files that name none, in any spelling (default: auto, m for those of "
    "up to 0.6 units and mm for larger ones); STEP and 3MF files name theirs"
)
ADVANCED_OPTIONS = (
    "--accept-open",
    "--com",
    "--mass",
    "--density",
    "--cluster-tolerance",
    "--round-sides",
    "--seed",
    "--workers",
)
POSE_OPTIONS = (
    "--cluster-tolerance",
    "--round-sides",
)
"""What counts as a pose, and as round."""

SCENE_OPTIONS = ("--restitution", "--drop-height")
SCENE_NAMES = tuple(
    name.removeprefix("--").replace("-", "_")
    for name in (*POSE_OPTIONS, *SCENE_OPTIONS)
)
"""Both, by the names of the scene's fields."""


def add_options(command: CommandParser, *names: str, **changes: Any) -> None:
    """Add options that commands share; `changes`: what this command has otherwise."""
    for name in names:
        group = command.advanced if name in ADVANCED_OPTIONS else command
        words = ("-o", name) if name == "--output" else (name,)
        group.add_argument(*words, **{**OPTIONS[name], **changes})


def add_part(command: CommandParser, *names: str, **unit: Any) -> None:
    """Add the part's file, unit and mass properties, then other shared options.

    `unit`: what this command has otherwise of that option.
    """
    # Most answers are nothing without an error, so few commands have that option.
    command.set_defaults(accept_open=False)
    add_options(command, "part")
    add_options(command, "--unit", **unit)
    add_options(command, "--body", "--com")
    masses = command.advanced.add_mutually_exclusive_group()
    for name in ("--mass", "--density"):
        masses.add_argument(name, **OPTIONS[name])
    add_options(command, *names)


def option_words(values: Mapping[str, Any], *names: str) -> list[str]:
    """Options as they are typed, of those names that have a value."""
    words: list[str] = []
    for name in names:
        value = values[name]
        if value is None or value is False or value == []:
            continue
        words.append(f"--{name.replace('_', '-')}")
        if value is not True:
            elements = value if isinstance(value, list) else [value]
            words += [
                element if isinstance(element, str) else repr(element)
                for element in elements
            ]
    return words


def output_folder(name: str) -> Path:
    """Path of a folder to write to."""
    if not name:
        raise RequestError(
            "the name of a folder to write to", "an empty one", "`.` is this one"
        )
    return Path(name)


def split_tables(files: Iterable[str]) -> tuple[list[Path], list[Path]]:
    """Files that are tables of counts by their names, and others, which are bags.

    One that is named twice counts once.
    """
    paths = {Path(file).resolve(): Path(file) for file in files}.values()
    tables = [path for path in paths if path.suffix.lower() in TABLE_ENDINGS]
    return tables, [path for path in paths if path not in tables]


def drop_scene(options: argparse.Namespace) -> DropScene:
    """The scene that the options name."""
    return DropScene(**scene_keywords(options))


def scene_keywords(options: argparse.Namespace) -> dict[str, Any]:
    """Scene of the options, by the keywords of the library's functions."""
    return {name: getattr(options, name) for name in SCENE_NAMES}


def add_drop_options(command: CommandParser, drops: int | None) -> None:
    """Add the number of drops (None: no default), target error, seed and threads."""
    default = "10000 for hybrid, ten million for auto" if drops is None else drops
    add_options(
        command,
        "--drops",
        default=drops,
        help="number of drops, or the most where a target "
        f"error is given (default: {default})",
    )
    command.add_argument(
        "--target-error",
        type=float,
        default=None if drops is None else 0.0,
        metavar="E",
        help="stop once the root mean square error over "
        "the poses is within this fraction with 90 %% confidence; 0.01 is one "
        "percentage point (default: none)",
    )
    add_options(command, "--seed", "--workers")
