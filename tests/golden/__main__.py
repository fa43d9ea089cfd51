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

"""Write, keep and compare what the commands answer for the golden parts.

    python -m tests.golden write FILE         answers of this checkout, in full
    python -m tests.golden keep               the answers that the tests compare with
    python -m tests.golden compare CHECKOUT   beside another checkout, to the last bit

`compare` ends with status 1 where anything differs but times.
"""

import json
import sys
import tempfile
from pathlib import Path

from tests.golden.comparing import condense
from tests.golden.node_bag import analysis_of_bag
from tests.golden.running import KEPT, answers_of
from tests.running import ROOT


def keep(answers):
    """Write the kept answers, a line a request."""
    lines = ",\n".join(
        f"{json.dumps(name)}: {json.dumps(condense(answer))}"
        for name, answer in answers.items()
    )
    KEPT.write_text(f"{{\n{lines}\n}}\n", encoding="utf-8")
    print(f"{len(answers)} answers in {KEPT}")


def compare(answers, others):
    """Print what differs, and return the exit status."""
    unlike = [
        name for name in answers | others if answers.get(name) != others.get(name)
    ]
    print(
        *(f"{name}: differs" for name in unlike), sep="\n", end="\n" if unlike else ""
    )
    print(
        f"{len(answers)} answers: "
        + (f"{len(unlike)} differ" if unlike else "all alike")
    )
    return 1 if unlike else 0


def all_answers(folder, checkout):
    """Answers of a checkout, and what a node of it records."""
    return answers_of(folder, checkout=checkout) | analysis_of_bag(folder, checkout)


def main(arguments):
    """Do what the first word says."""
    with tempfile.TemporaryDirectory() as folder:
        match arguments:
            case ["write", file]:
                answers = answers_of(Path(folder))
                Path(file).write_text(json.dumps(answers, indent=0), encoding="utf-8")
            case ["keep"]:
                keep(answers_of(Path(folder)))
            case ["compare", checkout]:
                return compare(
                    *(
                        all_answers(Path(folder) / name, root)
                        for name, root in (
                            ("here", ROOT),
                            ("there", Path(checkout).resolve()),
                        )
                    )
                )
            case _:
                sys.exit(__doc__)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
