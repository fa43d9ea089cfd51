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

"""Reads the tables of poses that commands print."""

import re


def table_head(text):
    """The names of the columns."""
    (line,) = (
        line
        for line in text.splitlines()
        if re.match(r"\s+poses?\s+(number\s+)?group\s", line)
    )
    return cells(line)


def table_rows(text):
    """The rows, each a dictionary by the names of the columns."""
    names = table_head(text)
    rows = [cells(line) for line in text.splitlines() if re.match(r"\s+\d", line)]
    return [dict(zip(names, row, strict=True)) for row in rows if len(row) > 3]


def cells(line):
    """What stands in the columns, which are at least two spaces apart."""
    return re.split(r"\s{2,}", line.strip())


def share(row):
    """Percentage in front of the bar."""
    return float(row["probability"].partition("%")[0])
