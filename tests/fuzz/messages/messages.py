"""Serialised messages that are not quite right, the same ones for the same seed."""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterator
from random import Random

from .message_bytes import BIG, HEADERS, LITTLE, encoded
from .message_seeds import HOSTILE_NUMBERS, Seeds

HEADER = 4
CLAIMS = (0, 1, 2, 3, 255, 65_535, 10**6, 44_739_243, 2**28, 357_913_942, 10**9, 2**31 - 1,
          2**31, 1_431_655_766, 2**32 - 2, 2**32 - 1)
"""Counts that lie; 3, 8, 12 or 24 times some of them overflow 32 bits."""

ENCAPSULATIONS = tuple(bytes((high, low)) for high in (0, 1, 255) for low in range(0x0C))
MOST_EXTRA = 400

Mutation = Callable[[Random, bytearray, bytes], bytearray]


def fuzzed(kind: type, seed: int, number: int) -> Iterator[bytes]:
    """Serialised messages of a type, a tenth of them as they should be.

    Parameters
    ----------
    kind : type
        One of `message_seeds.MAKERS`.
    seed : int
    number : int

    Returns
    -------
    iterator of bytes
    """
    chance = Random(f"{kind.__name__} {seed}")
    seeds = Seeds(chance)
    before = encoded(seeds.make(kind))
    for _ in range(number):
        order = BIG if chance.random() < 0.15 else LITTLE
        data = encoded(seeds.make(kind), order)
        before, sound = data, before
        yield data if chance.random() < 0.1 else mutated(chance, data, sound)


def mutated(chance: Random, data: bytes, other: bytes) -> bytes:
    """A message changed in one to four places.

    Parameters
    ----------
    chance : Random
    data : bytes
    other : bytes
        Another message, to splice with.
    """
    changed = bytearray(data)
    for _ in range(chance.choice((1, 1, 1, 2, 3, 4))):
        changed = chance.choice(MUTATIONS)(chance, changed, other)
    return bytes(changed)


def _flip(chance: Random, data: bytearray, _: bytes) -> bytearray:
    for _ in range(chance.choice((1, 1, 2, 8)) if data else 0):
        data[chance.randrange(len(data))] ^= 1 << chance.randrange(8)
    return data


def _truncate(chance: Random, data: bytearray, _: bytes) -> bytearray:
    return data[:chance.randrange(len(data) + 1)]


def _extend(chance: Random, data: bytearray, _: bytes) -> bytearray:
    size = chance.randrange(MOST_EXTRA)
    return data + (bytes(size) if chance.random() < 0.5 else chance.randbytes(size))


def _lie(chance: Random, data: bytearray, _: bytes) -> bytearray:
    """Claim another number where a count may be: a small number in a word of its own."""
    order = LITTLE if data[:2] == HEADERS[LITTLE][:2] else BIG
    places = [place for place in range(HEADER, len(data) - 3, 4)
              if 0 < struct.unpack_from(order + "I", data, place)[0] <= len(data)]
    if places:
        place = chance.choice(places)
        true = struct.unpack_from(order + "I", data, place)[0]
        claim = chance.choice((*CLAIMS, true + 1, true - 1, 2 * true, 3 * true))
        struct.pack_into(order + "I", data, place, claim)
    return data


def _poison(chance: Random, data: bytearray, _: bytes) -> bytearray:
    """Write hostile numbers where numbers may be, or everywhere."""
    places = list(range(HEADER, len(data) - 7, 8))
    everywhere = chance.random() < 0.1
    for place in places if everywhere else chance.sample(places, min(len(places), 2)):
        struct.pack_into("<d", data, place, chance.choice(HOSTILE_NUMBERS))
    return data


def _swap(chance: Random, data: bytearray, _: bytes) -> bytearray:
    """Exchange two fields of the same size."""
    size = chance.choice((4, 8, 24))
    places = range(HEADER, len(data) - size + 1, 4)
    if len(places) > 1:
        one, other = chance.choice(places), chance.choice(places)
        kept = data[one:one + size]
        data[one:one + size] = data[other:other + size]
        data[other:other + size] = kept
    return data


def _splice(chance: Random, data: bytearray, other: bytes) -> bytearray:
    place = 4 * chance.randrange(len(data) // 4 + 1)
    return data[:place] + other[4 * chance.randrange(len(other) // 4 + 1):]


def _repeat(chance: Random, data: bytearray, _: bytes) -> bytearray:
    begin, size = 4 * chance.randrange(len(data) // 4 + 1), chance.choice((4, 8, 24, 64))
    return data[:begin + size] + data[begin:]


def _relabel(chance: Random, data: bytearray, _: bytes) -> bytearray:
    """Say that it is in another encapsulation."""
    data[:2] = chance.choice(ENCAPSULATIONS)
    return data


MUTATIONS: tuple[Mutation, ...] = (_flip, _truncate, _extend, _lie, _lie, _poison, _swap, _splice,
                                   _repeat, _relabel)
