"""Gathers results out of PoseStatistics messages, a few numbers each."""

from __future__ import annotations

import math
from array import array
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...records.scene import Numbering
from .decoding import SECOND, fingerprint, read_field
from .results import Array, PoseTable, Prediction, ResultHistory

POSE_NUMBERS = ("height", "top", "margin", "barrier", "spread")
TEXTS = ("method", "plate", "job_id", "version")
NUMBERS = ("restitution", "drop_height", "expected_error", "largest_error", "plate_error")
COUNTS = ("drops", "unsettled")
PROBABILITIES = ("probability", "probability_low", "probability_high", "standard_error")


class ResultCollector:
    """Results of one part in one numbering with one number of poses.

    Holds eight bytes a probability and some eighty a result; the messages are let go.

    `first`: a decoded PoseStatistics, whose poses lay down the geometry.
    """

    def __init__(self, first: Any, numbering: Numbering) -> None:
        self.numbering = numbering
        self.radius = float(read_field(first, "radius", math.nan))
        self.poses = _pose_table(_sorted(first.poses))
        self.warnings: dict[str, None] = {}
        self._rows: dict[bytes, int] = {}
        self._methods: dict[str, int] = {}
        self._scenes: dict[Any, int] = {}
        self._predictions: dict[int, Prediction] = {}
        self._numbers = {name: array(code) for name, code in (
            ("time", "q"), ("method", "q"), ("prediction", "q"), ("restitution", "d"),
            ("drop_height", "d"), ("drops", "q"), ("unsettled", "q"), ("expected_error", "d"),
            ("largest_error", "d"))}
        self._flags = {"final": bytearray(), "latched": bytearray()}
        self._probability = array("d")

    def fits(self, message: Any) -> bool:
        """Whether a result numbers the same poses."""
        return bool(np.array_equal([pose.index for pose in _sorted(message.poses)],
                                   self.poses.index))

    def add(self, message: Any, time: int, latched: bool) -> None:
        """Take in a result, unless it is known: latched and answered, or in another bag."""
        found = _prediction(message, _sorted(message.poses), time)
        key = fingerprint(time, found.key, found.restitution, found.drops, found.unsettled,
                          found.seed, found.job_id, found.final, found.probability, found.count)
        row = self._rows.setdefault(key, len(self._rows))
        self.warnings.update(dict.fromkeys(read_field(message, "warnings", ())))
        if row < len(self._flags["final"]):
            self._flags["latched"][row] |= latched
            return
        self._flags["final"].append(found.final)
        self._flags["latched"].append(latched)
        scene = self._scenes.setdefault(found.key, len(self._scenes))
        numbers = {"method": self._methods.setdefault(found.method, len(self._methods)),
                   "prediction": scene}
        for name, column in self._numbers.items():
            column.append(numbers[name] if name in numbers else getattr(found, name))
        self._probability.frombytes(found.probability.tobytes())
        known = self._predictions.get(scene)
        if known is None or found.knows_more_than(known):
            self._predictions[scene] = found

    def history(self) -> ResultHistory:
        """Everything so far, by time."""
        columns = {name: _copy(column, column.typecode) for name, column in self._numbers.items()}
        flags = {name: _copy(column, "?") for name, column in self._flags.items()}
        probability = _copy(self._probability, "d").reshape(len(columns["time"]), -1)
        order = np.argsort(columns["time"], kind="stable")
        names = np.array(list(self._methods), dtype=np.str_)
        columns["method"] = names[columns["method"]]
        ordered = {name: column[order] for name, column in {**columns, **flags}.items()}
        return ResultHistory(self.numbering, self.poses, **ordered,
                             probability=probability[order],
                             predictions=tuple(self._predictions.values()))


def _copy(column: array[Any] | bytearray, code: str) -> NDArray[Any]:
    return np.frombuffer(column, dtype=code).copy()


def _sorted(poses: Sequence[Any]) -> list[Any]:
    return sorted(poses, key=lambda pose: int(pose.index))


def _pose_table(poses: Sequence[Any]) -> PoseTable:
    down = [(pose.down.x, pose.down.y, pose.down.z) if hasattr(pose, "down")
            else (math.nan,) * 3 for pose in poses]
    return PoseTable(
        np.array([pose.index for pose in poses], dtype=np.int64),
        # Without groups every pose is a group of its own.
        np.array([read_field(pose, "group", pose.index) for pose in poses], dtype=np.int64),
        np.array(down, dtype=np.float64).reshape(-1, 3),
        **{name: _numbers(poses, name) for name in POSE_NUMBERS})


def _numbers(poses: Sequence[Any], name: str) -> Array:
    return np.array([read_field(pose, name, math.nan) for pose in poses], dtype=np.float64)


def _prediction(message: Any, poses: Sequence[Any], time: int) -> Prediction:
    spent = read_field(message, "compute_time", None)
    told: dict[str, Any] = {
        **{name: str(read_field(message, name, "")) for name in TEXTS},
        **{name: float(read_field(message, name, math.nan)) for name in NUMBERS},
        **{name: int(np.int64(read_field(message, name, 0))) for name in COUNTS},
        **{name: _numbers(poses, name) for name in PROBABILITIES}}
    return Prediction(
        **told, time=time,
        seed=int(read_field(message, "seed", 0)),
        seconds=math.nan if spent is None else spent.sec + spent.nanosec / SECOND,
        final=bool(read_field(message, "final", True)),
        count=np.array([read_field(pose, "count", 0) for pose in poses], dtype=np.int64))
