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

"""Writes the table of parameters in docs/node.md: `python -m
tests.house.parameters_table`.
"""

import sys
from pathlib import Path

from ros_pose_stats.node.settings import TABLE

PAGE = Path(__file__).resolve().parents[2] / "docs" / "node.md"
HEAD = "| name | default | meaning |\n|---|---|---|\n"


def parameters_table() -> str:
    """One row a parameter, as the node declares it."""
    return HEAD + "".join(
        f"| `{name}` | `{_shown(parameter.default)}` | "
        f"{_meaning(**parameter.metadata)} |\n"
        for name, parameter in TABLE.items()
    )


def _shown(default) -> str:
    if isinstance(default, tuple):
        default = list(default)
    return str(default).lower() if isinstance(default, bool) else str(default) or "''"


def _meaning(description: str, fixed: bool, bounds: tuple[float, ...]) -> str:
    return description + (" Set at the start only." if fixed else "")


def main() -> int:
    """Write the table, which is the end of the page."""
    page = PAGE.read_text(encoding="utf-8")
    PAGE.write_text(page[: page.index(HEAD)] + parameters_table(), encoding="utf-8")
    print(PAGE)
    return 0


if __name__ == "__main__":
    sys.exit(main())
