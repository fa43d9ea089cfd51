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

"""Answers condensed to what is kept, and compared: exactly, but for floats that others
round.

Kept of an answer are a digest of all that is exact (counts, digests, indices, words,
structure) and its floating-point numbers to twelve digits. Libraries round otherwise on
other processors, so numbers agree within `ROUNDING`, and those printed in text within
one unit of their last digit.
"""

import hashlib
import json
import re

ROUNDING = 1e-9
"""Relative and absolute: a thousand times what estimates differed by between
processors.
"""

BITS = "bits"
"""Key of what is equal to the last bit on one machine alone; not kept."""

DECIMAL = re.compile(r"(?<![\w.])[-+−]?\d+(?:\.\d+(?:e[-+]?\d+)?|e[-+]\d+)(?!\w)")


def condense(answer):
    """Digest of what is exact, and the numbers that are not, with the unit of their
    last digit.
    """
    numbers = []

    def plain(value):
        if isinstance(value, float):
            numbers.append(float(f"{value:.12g}"))
            return "#"
        if isinstance(value, str):
            return DECIMAL.sub(take, value)
        if isinstance(value, dict):
            return {key: plain(item) for key, item in value.items() if key != BITS}
        return [plain(item) for item in value] if isinstance(value, list) else value

    def take(match):
        text = match.group().replace("−", "-")
        mantissa, _, exponent = text.partition("e")
        unit = 10.0 ** (int(exponent or 0) - len(mantissa.partition(".")[2]))
        numbers.append([float(text), unit])
        return "#"

    exact = json.dumps(plain(answer), sort_keys=False, ensure_ascii=False)
    return {
        "exact": hashlib.sha256(exact.encode()).hexdigest()[:24],
        "numbers": numbers,
    }


def differences(answers, reference):
    """A line for every kept request whose answer is another, empty where all agree."""
    lines = []
    for name, expected in reference.items():
        if name not in answers:
            lines.append(f"{name}: not answered")
            continue
        condensed = condense(answers[name])
        if condensed["exact"] != expected["exact"] or len(condensed["numbers"]) != len(
            expected["numbers"]
        ):
            lines.append(f"{name}: what is exact differs")
            continue
        pairs = zip(
            map(number, condensed["numbers"]),
            map(number, expected["numbers"]),
            strict=True,
        )
        unequal = [
            (value, reference_value)
            for (value, unit), (reference_value, _) in pairs
            if abs(value - reference_value)
            > max(1.001 * unit, ROUNDING * (1.0 + abs(reference_value)))
        ]
        if unequal:
            value, expected_value = max(
                unequal, key=lambda pair: abs(pair[0] - pair[1])
            )
            lines.append(
                f"{name}: {len(unequal)} numbers differ, most {value!r} from "
                f"{expected_value!r}"
            )
    return lines


def number(text):
    """A number and the unit of its last digit, 0 of one that was not printed."""
    return text if isinstance(text, list) else (text, 0.0)
