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

"""Command line of the fuzz: meshes, objects of any kind, large meshes, messages to a
node.
"""

from collections import Counter
from collections.abc import Callable

from ..frame import Outcome, Setting, Trial, program
from .kinds import KINDS
from .large import large_inputs
from .messages.door import bytes_on_topics, hostile_names, requests_and_goals
from .watched import Watched

INPUTS = 270
"""Of each kind: 11 340 in all."""

SHORT = 0.1
THOROUGH_EVERY = 5
"""One input of so many is asked about at every tolerance and given in other ways
too.
"""


def inputs_of(kind: str, watched: Watched) -> Callable[[Setting], Outcome]:
    """The work of trying inputs of a kind."""

    def work(setting: Setting) -> Outcome:
        outcome = Outcome()
        accepted = 0
        compared = Counter[str]()
        slowest = (0.0, 0)
        for number in range(setting.of(INPUTS)):
            tried = watched.tried(
                kind, setting.seed + number, number % THOROUGH_EVERY == 0
            )
            outcome.tried += 1
            accepted += not tried.refusal
            slowest = max(slowest, (tried.seconds, tried.seed))
            compared.update([tried.compared] * bool(tried.compared))
            if tried.faults:
                outcome.broken.append(
                    f"{'; '.join(tried.faults)[:250]}: python -m lab.trials.fuzz "
                    f"--only '{kind}' --seed {tried.seed} --size 0"
                )
        if outcome.tried > 200 and not accepted and KINDS[kind].fate != "refused":
            outcome.broken.append("none is taken, so nothing is tried")
        if compared.total() > 20 and not compared["same"]:
            outcome.broken.append("none could be given in another way")
        ways = "".join(f", {name} {count}" for name, count in compared.most_common())
        outcome.seen = (
            f"{accepted} taken, slowest {slowest[0]:.2f} s (seed {slowest[1]})"
            + (f"; given in other ways{ways}" if ways else "")
        )
        return outcome

    return work


def main() -> int:
    """Try, print, and return the exit status."""
    with Watched() as watched:
        return program(
            "fuzz",
            [
                *(
                    Trial(kind, KINDS[kind].done, inputs_of(kind, watched))
                    for kind in KINDS
                ),
                large_inputs,
                bytes_on_topics,
                requests_and_goals,
                hostile_names,
            ],
            SHORT,
        )


if __name__ == "__main__":
    raise SystemExit(main())
