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

"""The results that a bag holds for one part: what they said, and how it changed."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...base.methods import OBSERVED, SIMULATION
from ...base.text import SECOND
from ...core.records import Array, Index, Mask
from ...core.records.notes import Note, notes_of
from ...core.records.poses import POSE_FIELDS
from ...core.records.scene import Numbering, describe_scene
from ...core.records.statistics import STATISTICS_FIELDS
from ...core.statistics.model_gap import Forecast, share_errors
from ...node.recording.decoding import fingerprint


@dataclass(frozen=True, eq=False)
class PoseTable:
    """Geometry of a part's poses in one numbering, in the order of their index."""

    index: Index  # (K,)
    group: Index
    down: Array  # (K, 3); unit vectors in the part frame
    height: Array  # (K,); metres
    top: Array
    margin: Array  # (K,); radians
    barrier: Array
    spread: Array


@dataclass(frozen=True, eq=False)
class Prediction:
    """What a method says in a scene: the largest simulation, or the newest estimate."""

    method: str
    restitution: float  # as asked for
    drop_height: float  # metres; NaN where the method ignores it
    plate: str  # name of the plate; empty where none was given
    time: int  # nanoseconds since 1970
    drops: int
    unsettled: int
    seed: int
    expected_error: float  # fractions; NaN where unknown
    largest_error: float
    plate_error: float
    seconds: float  # that computing took
    job_id: str
    version: str
    final: bool
    probability: Array  # (K,); in the order of the pose table
    probability_low: Array
    probability_high: Array
    standard_error: Array
    count: Index  # (K,) int; drops that came to rest in each pose; 0 for an estimate

    @property
    def scene(self) -> str:
        """How high and how bouncy, in one sentence."""
        return describe_scene(self.restitution, self.drop_height)

    @property
    def key(self) -> tuple[str, float | None, float | None]:
        """Method and scene; a method that ignores the drop height has no scene."""
        if math.isnan(self.drop_height):
            return self.method, None, None
        return self.method, self.restitution, self.drop_height

    @property
    def counted(self) -> bool:
        """Whether the probabilities are counts of drops, with an error of their own."""
        return self.method == SIMULATION and bool(self.count.any())

    def forecast(self, poses: PoseTable) -> Forecast:
        """What it says of counts in these poses."""
        return Forecast(
            self.probability,
            share_errors(self.probability, self.standard_error, self.expected_error),
            self.plate_error,
            self.count if self.counted else None,
            poses.group,
            poses.index,
        )

    def knows_more_than(self, other: "Prediction") -> bool:
        """Whether this one should stand for their common scene."""
        settled = self.drops - self.unsettled
        other_settled = other.drops - other.unsettled
        return (settled, self.time) >= (other_settled, other.time)


@dataclass(frozen=True, eq=False)
class ResultHistory:
    """All results of a part in one numbering, by time."""

    numbering: Numbering
    poses: PoseTable
    time: Index  # (n,) int; nanoseconds since 1970
    method: NDArray[np.str_]  # (n,) str
    restitution: Array  # (n,)
    drop_height: Array  # (n,); metres; NaN where the method ignores it
    drops: Index  # (n,)
    unsettled: Index
    expected_error: Array  # (n,); fractions; NaN where unknown
    largest_error: Array
    final: Mask  # (n,); whether it was a job's last word
    latched: Mask  # (n,); whether subscribers got it, or a caller alone
    prediction: Index  # (n,) int; the number of the prediction of its method and scene
    probability: Array  # (n, K)
    # one a method and scene, in the order of first appearance
    predictions: tuple[Prediction, ...]

    @property
    def largest_change(self) -> Array:
        """Largest change (n,) of a probability since the result before; first NaN."""
        changes = np.full(len(self.time), math.nan)
        if len(self.time) > 1:
            differences = np.abs(np.diff(self.probability, axis=0))
            changes[1:] = differences.max(axis=1, initial=0.0)
        return changes

    @property
    def scene(self) -> list[str]:
        """Of each result, how high and how bouncy, in one sentence."""
        return [
            describe_scene(restitution, drop_height)
            for restitution, drop_height in zip(
                self.restitution.tolist(), self.drop_height.tolist(), strict=True
            )
        ]

    @property
    def scenes(self) -> list[str]:
        """Different scenes, by first appearance; methods blind to them have none."""
        scenes = [
            prediction.scene
            for prediction in self.predictions
            if not math.isnan(prediction.drop_height)
        ]
        return list(dict.fromkeys(scenes))

    @property
    def foretold(self) -> tuple[Prediction, ...]:
        """Those that have not learnt from counts, so that counts can judge them."""
        return tuple(
            prediction
            for prediction in self.predictions
            if prediction.method != OBSERVED
        )

    @property
    def leading(self) -> Prediction:
        """The prediction to go by: the largest simulation, else the newest estimate."""
        leading, *others = self.foretold or self.predictions
        for prediction in others:
            if prediction.knows_more_than(leading):
                leading = prediction
        return leading


POSE = tuple(field.name for field in fields(PoseTable))
PREDICTED = tuple(
    field.name for field in fields(Prediction) if field.type in (Array, Index)
)
ABOUT = tuple(field.name for field in fields(Prediction) if field.name not in PREDICTED)
"""Columns of the poses, of a prediction for each pose, and what it says of all."""

_NUMBERS_OF_POSES = tuple(name for name in POSE_FIELDS if name in POSE[3:])
_SHARES = tuple(name for name in POSE_FIELDS if name in PREDICTED and name != "count")
_NUMBERS = tuple(
    field.name
    for field in fields(Prediction)
    if field.type is float and field.name in STATISTICS_FIELDS
)
_TEXTS = tuple(field.name for field in fields(Prediction) if field.type is str)
"""What a message has under the same names."""


class ResultCollector:
    """Results of one part in one numbering; the first has the geometry of the poses."""

    def __init__(self, first: Any, numbering: Numbering) -> None:
        self.numbering = numbering
        self._code = int(getattr(first, "numbering", 0))  # 0: of a node up to 0.2.0
        self.radius = float(getattr(first, "radius", math.nan))
        self.poses = _pose_table(_sorted(first.poses))
        self._warnings: dict[tuple[Any, str], tuple[int, list[Note]]] = {}
        self._rows: dict[bytes, int] = {}
        self._methods: dict[str, int] = {}
        self._scenes: dict[Any, int] = {}
        self._predictions: dict[int, Prediction] = {}
        columns: dict[str, Any] = {
            "time": "i8",
            "method": "i8",
            "prediction": "i8",
            "restitution": "f8",
            "drop_height": "f8",
            "drops": "i8",
            "unsettled": "i8",
            "expected_error": "f8",
            "largest_error": "f8",
            "final": "?",
            "latched": "?",
            "probability": ("f8", self.poses.index.shape),
        }
        self._columns = tuple(columns)
        self._kind = np.dtype(list(columns.items()))
        self._table = bytearray()

    def fits(self, message: Any) -> bool:
        """Whether a result numbers the same poses."""
        code = int(getattr(message, "numbering", self._code))
        return (not self._code or code == self._code) and bool(
            np.array_equal(
                [pose.index for pose in _sorted(message.poses)], self.poses.index
            )
        )

    def add(self, message: Any, time: int, latched: bool) -> None:
        """Take in a result once: latched and answered, and out of several bags."""
        result = _prediction(message, _sorted(message.poses), time)
        content = fingerprint(
            time,
            result.key,
            result.restitution,
            result.drops,
            result.unsettled,
            result.seed,
            result.job_id,
            result.final,
            result.probability,
            result.count,
        )
        self._keep_warnings(result.key, notes_of(message), time)
        if content in self._rows:
            self._results()["latched"][self._rows[content]] |= latched
            return
        number = self._scenes.setdefault(result.key, len(self._scenes))
        cells = {name: getattr(result, name, None) for name in self._columns}
        cells["method"] = self._methods.setdefault(result.method, len(self._methods))
        cells["prediction"] = number
        cells["latched"] = latched
        self._table += np.array([tuple(cells.values())], self._kind).tobytes()
        self._rows[content] = len(self._rows)
        prediction = self._predictions.get(number)
        if prediction is None or result.knows_more_than(prediction):
            self._predictions[number] = result

    def _keep_warnings(self, key: Any, notes: Iterable[Note], time: int) -> None:
        """Keep those of the newest result of a scene and method that had such a code.

        Figures in them change with every part that a camera counts.
        """
        notes_by_code: dict[str, list[Note]] = {}
        for note in notes:
            notes_by_code.setdefault(note.code, []).append(note)
        for code, notes_now in notes_by_code.items():
            newest = self._warnings.get((key, code))
            if newest is None or time >= newest[0]:
                self._warnings[key, code] = time, notes_now

    @property
    def warnings(self) -> list[Note]:
        """What results said, in each scene a code as it was said last."""
        by_time = sorted(self._warnings.values(), key=lambda kept: kept[0])
        return [note for _, notes in by_time for note in notes]

    def history(self) -> ResultHistory:
        """Everything so far, by time."""
        results = self._results()
        results = results[np.argsort(results["time"], kind="stable")]
        columns = {name: results[name].copy() for name in self._columns}
        methods = np.array(list(self._methods), dtype=np.str_)
        columns["method"] = methods[columns["method"]]
        return ResultHistory(
            self.numbering,
            self.poses,
            **columns,
            predictions=tuple(self._predictions.values()),
        )

    def _results(self) -> NDArray[Any]:
        return np.frombuffer(self._table, self._kind)


def _sorted(poses: Sequence[Any]) -> list[Any]:
    return sorted(poses, key=lambda pose: int(pose.index))


def _pose_table(poses: Sequence[Any]) -> PoseTable:
    # Older messages may lack fields; without groups every pose is a group of its own.
    groups = [getattr(pose, "group", pose.index) for pose in poses]
    downs = [_down(pose) for pose in poses]
    return PoseTable(
        np.array([pose.index for pose in poses], dtype=np.int64),
        np.array(groups, dtype=np.int64),
        np.array(downs, dtype=np.float64).reshape(-1, 3),
        **{name: _numbers(poses, name) for name in _NUMBERS_OF_POSES},
    )


def _down(pose: Any) -> tuple[float, float, float]:
    if not hasattr(pose, "down"):
        return math.nan, math.nan, math.nan
    return pose.down.x, pose.down.y, pose.down.z


def _numbers(poses: Sequence[Any], name: str) -> Array:
    return np.array([getattr(pose, name, math.nan) for pose in poses], dtype=np.float64)


def _prediction(message: Any, poses: Sequence[Any], time: int) -> Prediction:
    duration = getattr(message, "compute_time", None)
    seconds = math.nan
    if duration is not None:
        seconds = duration.sec + duration.nanosec / SECOND
    texts: dict[str, Any] = {name: str(getattr(message, name, "")) for name in _TEXTS}
    numbers: dict[str, Any] = {
        name: float(getattr(message, name, math.nan)) for name in _NUMBERS
    }
    shares: dict[str, Any] = {name: _numbers(poses, name) for name in _SHARES}
    return Prediction(
        **texts,
        **numbers,
        **shares,
        time=time,
        drops=int(np.int64(getattr(message, "drops", 0))),
        unsettled=int(np.int64(getattr(message, "unsettled", 0))),
        seed=int(getattr(message, "seed", 0)),
        seconds=seconds,
        final=bool(getattr(message, "final", True)),
        count=np.array([getattr(pose, "count", 0) for pose in poses], dtype=np.int64),
    )
