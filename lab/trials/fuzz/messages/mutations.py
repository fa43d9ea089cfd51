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

"""Serialised messages that are not quite right, the same ones for the same seed."""

import struct
from collections.abc import Iterator
from random import Random

from .cdr import BIG, HEADERS, LITTLE, encoded
from .seeds import HOSTILE_NUMBERS, Seeds

HEADER = 4
CLAIMS = (
    0,
    1,
    2,
    3,
    255,
    65_535,
    10**6,
    44_739_243,
    2**28,
    357_913_942,
    10**9,
    2**31 - 1,
    2**31,
    1_431_655_766,
    2**32 - 2,
    2**32 - 1,
)
"""Counts that lie; 3, 8, 12 or 24 times some of them overflow 32 bits."""

ENCAPSULATIONS = tuple(
    bytes((high, low)) for high in (0, 1, 255) for low in range(0x0C)
)


def fuzzed(kind: type, seed: int, number: int) -> Iterator[bytes]:
    """So many serialised messages of a type, a tenth of them as they should be."""
    chance = Random(f"{kind.__name__} {seed}")
    seeds = Seeds(chance)
    previous = encoded(seeds.make(kind))
    for _ in range(number):
        data = encoded(seeds.make(kind), BIG if chance.random() < 0.15 else LITTLE)
        previous, donor = data, previous
        yield data if chance.random() < 0.1 else mutated(chance, data, donor)


def mutated(chance: Random, data: bytes, donor: bytes) -> bytes:
    """A message changed in one to four places, perhaps spliced with another one."""
    changed = bytearray(data)
    for _ in range(chance.choice((1, 1, 1, 2, 3, 4))):
        changed = chance.choice(MUTATIONS)(chance, changed, donor)
    return bytes(changed)


def _word(chance, data):
    """The place of some word, or the end."""
    return 4 * chance.randrange(len(data) // 4 + 1)


def _flip(chance, data, _):
    for _ in range(chance.choice((1, 1, 2, 8)) if data else 0):
        data[chance.randrange(len(data))] ^= 1 << chance.randrange(8)
    return data


def _truncate(chance, data, _):
    return data[: chance.randrange(len(data) + 1)]


def _extend(chance, data, _):
    size = chance.randrange(400)
    return data + (bytes(size) if chance.random() < 0.5 else chance.randbytes(size))


def _lie(chance, data, _):
    """Claim another number where a count may be: a small number in a word of its
    own.
    """
    code = ("<" if data[:2] == HEADERS[LITTLE][:2] else ">") + "I"
    places = [
        position
        for position in range(HEADER, len(data) - 3, 4)
        if 0 < struct.unpack_from(code, data, position)[0] <= len(data)
    ]
    if places:
        position = chance.choice(places)
        true = struct.unpack_from(code, data, position)[0]
        struct.pack_into(
            code,
            data,
            position,
            chance.choice((*CLAIMS, true + 1, true - 1, 2 * true, 3 * true)),
        )
    return data


def _poison(chance, data, _):
    """Write hostile numbers where numbers may be, or everywhere."""
    places = list(range(HEADER, len(data) - 7, 8))
    chosen = (
        places if chance.random() < 0.1 else chance.sample(places, min(len(places), 2))
    )
    for position in chosen:
        struct.pack_into("<d", data, position, chance.choice(HOSTILE_NUMBERS))
    return data


def _swap(chance, data, _):
    """Exchange two fields of the same size."""
    size = chance.choice((4, 8, 24))
    places = range(HEADER, len(data) - size + 1, 4)
    if len(places) > 1:
        first = chance.choice(places)
        second = chance.choice(places)
        field = data[first : first + size]
        data[first : first + size] = data[second : second + size]
        data[second : second + size] = field
    return data


def _splice(chance, data, donor):
    return data[: _word(chance, data)] + donor[_word(chance, donor) :]


def _repeat(chance, data, _):
    begin = _word(chance, data)
    return data[: begin + chance.choice((4, 8, 24, 64))] + data[begin:]


def _relabel(chance, data, _):
    """Say that it is in another encapsulation."""
    data[:2] = chance.choice(ENCAPSULATIONS)
    return data


MUTATIONS = (
    _flip,
    _truncate,
    _extend,
    _lie,
    _lie,
    _poison,
    _swap,
    _splice,
    _repeat,
    _relabel,
)
