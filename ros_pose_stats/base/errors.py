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

"""The one family of errors that this package raises on purpose.

Each error is built from facts: what was expected, what came instead, and what to do
about it. The message is written here, so that every refusal reads alike and fits in
one line on a terminal, in a service response or in a diagnostic.
"""

_LONGEST = 500  # characters of what came; an array may print as pages


class PoseStatsError(ValueError):
    """A refused input.

    Parameters
    ----------
    expected : str
        What would have been accepted, with the bound and its unit.
    finding : str
        What came, with its value.
    remedy : str
        What the user can do.
    """

    def __init__(self, expected: str, finding: str, remedy: str) -> None:
        line = " ".join(part.strip() for part in finding.splitlines())
        if len(line) > _LONGEST:
            line = f"{line[: _LONGEST - 1]}…"
        self.expected = expected
        self.finding = line
        self.remedy = remedy
        super().__init__(f"expected {expected}, got {line}; {remedy}")

    def __reduce__(self) -> "tuple[type[PoseStatsError], tuple[str, str, str]]":
        return type(self), (self.expected, self.finding, self.remedy)


class MeshError(PoseStatsError):
    """A mesh that does not describe a solid part."""


class MassPropertiesError(PoseStatsError):
    """Mass, centre of mass or inertia that no rigid part of this shape can have."""


class RequestError(PoseStatsError):
    """A method name, option or parameter out of its range."""


class MeshFileError(PoseStatsError):
    """A mesh file that cannot be read."""


class TimedOutError(PoseStatsError):
    """Work that takes longer than it may."""


class BagError(PoseStatsError):
    """A bag that cannot be read, or that holds nothing to analyse."""


class BatchError(PoseStatsError):
    """Work in pieces that cannot go on: a folder, process or cluster fails."""


def reason(error: BaseException) -> str:
    """An error in one line, never empty."""
    text = str(error)
    if isinstance(error, OSError) and error.strerror:
        text = error.strerror
    return " ".join((text or type(error).__name__).split())
