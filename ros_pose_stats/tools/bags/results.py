"""The results that a bag holds for one part: what they said, and how it changed."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...base.methods import OBSERVED, SIMULATION
from ...core.records import Array, Index, Mask
from ...core.records.poses import POSE_FIELDS
from ...core.records.scene import Numbering, describe_scene
from ...core.records.statistics import STATISTICS_FIELDS
from ...node.recording.decoding import SECOND, fingerprint


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
    """What a method says in a scene: the simulation with most drops, or the newest estimate."""

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
        """What tells predictions apart; a method that ignores the drop height is blind."""
        if math.isnan(self.drop_height):
            return self.method, None, None
        return self.method, self.restitution, self.drop_height

    @property
    def counted(self) -> bool:
        """Whether the probabilities are counts of drops, with an error of their own."""
        return self.method == SIMULATION and bool(self.count.any())

    @property
    def errors(self) -> Array:
        """Standard errors (K,); from the expected error where none are told, NaN without that."""
        spread = self.probability * (1.0 - self.probability)
        if np.isfinite(self.standard_error).all() or not spread.sum() > 0.0:
            return self.standard_error
        return np.asarray(
            self.expected_error * np.sqrt(spread * spread.size / spread.sum())
        )

    def knows_more_than(self, other: "Prediction") -> bool:
        """Whether this one should stand for their common scene."""
        mine = self.drops - self.unsettled
        others = other.drops - other.unsettled
        return (mine, self.time) >= (others, other.time)


@dataclass(frozen=True, eq=False)
class ResultHistory:
    """All results of a part in one numbering, by time."""

    numbering: Numbering
    poses: PoseTable
    time: Index  # (n,) int; nanoseconds since 1970
    method: NDArray[np.str_]  # (n,) str
    restitution: Array  # (n,); the latter in metres, NaN where the method ignores it
    drop_height: Array
    drops: Index  # (n,)
    unsettled: Index
    expected_error: Array  # (n,); fractions; NaN where unknown
    largest_error: Array
    # (n,); whether it was a job's last word; whether subscribers got it or a caller alone
    final: Mask
    latched: Mask
    prediction: (
        Index  # (n,) int; which of the predictions speaks for its method and scene
    )
    probability: Array  # (n, K)
    predictions: tuple[
        Prediction, ...
    ]  # one a method and scene, in the order of first appearance

    @property
    def largest_change(self) -> Array:
        """Largest change of a probability since the result before, (n,); NaN for the first."""
        found = np.full(len(self.time), math.nan)
        if len(self.time) > 1:
            found[1:] = np.abs(np.diff(self.probability, axis=0)).max(
                axis=1, initial=0.0
            )
        return found

    @property
    def scene(self) -> list[str]:
        """Of each result, how high and how bouncy, in one sentence."""
        return [
            describe_scene(*each)
            for each in zip(
                self.restitution.tolist(), self.drop_height.tolist(), strict=True
            )
        ]

    @property
    def scenes(self) -> list[str]:
        """Different scenes, in the order of first appearance; methods blind to them have none."""
        return list(
            dict.fromkeys(
                one.scene for one in self.predictions if not math.isnan(one.drop_height)
            )
        )

    @property
    def foretold(self) -> tuple[Prediction, ...]:
        """Those that have not learnt from counts, so that counts can judge them."""
        return tuple(one for one in self.predictions if one.method != OBSERVED)

    @property
    def leading(self) -> Prediction:
        """The prediction to go by: the largest simulation, else the newest estimate."""
        best, *others = self.foretold or self.predictions
        for one in others:
            if one.knows_more_than(best):
                best = one
        return best


POSE = tuple(field.name for field in fields(PoseTable))
PREDICTED = tuple(
    field.name for field in fields(Prediction) if field.type in (Array, Index)
)
ABOUT = tuple(field.name for field in fields(Prediction) if field.name not in PREDICTED)
"""Columns of the poses, of a prediction of each of them, and what is said of all at once."""

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
    """Results of one part in one numbering; the poses of the first lay down the geometry."""

    def __init__(self, first: Any, numbering: Numbering) -> None:
        self.numbering = numbering
        self.radius = float(getattr(first, "radius", math.nan))
        self.poses = _pose_table(_sorted(first.poses))
        self.warnings: dict[str, None] = {}
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
        return bool(
            np.array_equal(
                [pose.index for pose in _sorted(message.poses)], self.poses.index
            )
        )

    def add(self, message: Any, time: int, latched: bool) -> None:
        """Take in a result, unless it is known: latched and answered, or in another bag."""
        found = _prediction(message, _sorted(message.poses), time)
        key = fingerprint(
            time,
            found.key,
            found.restitution,
            found.drops,
            found.unsettled,
            found.seed,
            found.job_id,
            found.final,
            found.probability,
            found.count,
        )
        self.warnings.update(dict.fromkeys(getattr(message, "warnings", ())))
        if key in self._rows:
            self._results()["latched"][self._rows[key]] |= latched
            return
        scene = self._scenes.setdefault(found.key, len(self._scenes))
        own = {
            "method": self._methods.setdefault(found.method, len(self._methods)),
            "prediction": scene,
            "latched": latched,
        }
        row = tuple(
            own[name] if name in own else getattr(found, name) for name in self._columns
        )
        self._table += np.array([row], self._kind).tobytes()
        self._rows[key] = len(self._rows)
        known = self._predictions.get(scene)
        if known is None or found.knows_more_than(known):
            self._predictions[scene] = found

    def history(self) -> ResultHistory:
        """Everything so far, by time."""
        results = self._results()
        results = results[np.argsort(results["time"], kind="stable")]
        columns = {name: results[name].copy() for name in self._columns}
        columns["method"] = np.array(list(self._methods), dtype=np.str_)[
            columns["method"]
        ]
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
    down = [
        (pose.down.x, pose.down.y, pose.down.z)
        if hasattr(pose, "down")
        else (math.nan,) * 3
        for pose in poses
    ]
    return PoseTable(
        np.array([pose.index for pose in poses], dtype=np.int64),
        # Without groups every pose is a group of its own.
        np.array(
            [getattr(pose, "group", pose.index) for pose in poses], dtype=np.int64
        ),
        np.array(down, dtype=np.float64).reshape(-1, 3),
        **{name: _numbers(poses, name) for name in _NUMBERS_OF_POSES},
    )


def _numbers(poses: Sequence[Any], name: str) -> Array:
    return np.array([getattr(pose, name, math.nan) for pose in poses], dtype=np.float64)


def _prediction(message: Any, poses: Sequence[Any], time: int) -> Prediction:
    spent = getattr(message, "compute_time", None)
    same: dict[str, Any] = {
        **{name: str(getattr(message, name, "")) for name in _TEXTS},
        **{name: float(getattr(message, name, math.nan)) for name in _NUMBERS},
        **{name: _numbers(poses, name) for name in _SHARES},
    }
    return Prediction(
        **same,
        time=time,
        drops=int(np.int64(getattr(message, "drops", 0))),
        unsettled=int(np.int64(getattr(message, "unsettled", 0))),
        seed=int(getattr(message, "seed", 0)),
        seconds=math.nan if spent is None else spent.sec + spent.nanosec / SECOND,
        final=bool(getattr(message, "final", True)),
        count=np.array([getattr(pose, "count", 0) for pose in poses], dtype=np.int64),
    )
