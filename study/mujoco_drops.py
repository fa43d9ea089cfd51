"""Drops of a part by MuJoCo, for comparison, where it is installed.

MuJoCo needs a time step and gets restitution from a soft contact, whose depth takes the
place of a tolerance. Lengths are in radii, time in sqrt(radius / g), mass 1.

A direct `solref = (-softness.stiffness, -softness.damping)` lets the depth x of a
touching vertex obey x'' + 2 zeta omega x' + omega² x = 0, whatever the leverage, until
the force would pull. With zeta = cos(phi), phi being imaginary above zeta = 1, this
gives

    restitution = exp(-2 phi / tan(phi)),    duration = 2 phi / (omega sin(phi)),
    depth       = speed sqrt(restitution) / omega.

`fit_contact` aims these at the wanted restitution and depth and corrects the aim by
what first impacts from 20 radii show.

The integrator is `implicitfast`, which in MuJoCo 4.0 loses energy in free rotation (0.6
% to 14 % in 20 units of time at a step of 0.002 and 5 radians a unit). `Euler`, and
`implicitfast` in 3.3, gain as much, so that long drops can blow up; `RK4`, exact there,
takes three times as long.
"""

from __future__ import annotations

import cmath
import math
import time
from importlib import import_module
from importlib.util import find_spec
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ros_pose_stats.core.records import Part
from ros_pose_stats.core.records.scene import DEFAULT_CLUSTER_TOLERANCE
from ros_pose_stats.core.resting.poses import resting_poses

Array = NDArray[np.float64]

IMPACTS = 64
CORRECTIONS = 4


class Contact(NamedTuple):
    """A contact and the time step that it is computed with."""

    stiffness: float
    damping: float
    step: float


def contact(restitution: float, depth: float, steps: int) -> Contact:
    """Stiffness, damping and time step by the closed forms above, for a fall from 20
    radii.
    """
    low = 0.0
    high = 1e3  # of zeta; restitution falls with it
    for _ in range(100):
        zeta = 0.5 * (low + high)
        phi = cmath.acos(zeta)
        if (2.0 * phi / cmath.tan(phi)).real < -math.log(restitution):
            low = zeta
        else:
            high = zeta
    omega = math.sqrt(2.0 * (HEIGHT - 1.0) * restitution) / depth
    duration = (2.0 * phi / cmath.sin(phi)).real / omega
    return Contact(omega**2, 2.0 * zeta * omega, duration / steps)


def fit_contact(
    plate: Plate, restitution: float, penetration: float, steps: int
) -> Contact:
    """Find a contact of so many time steps, correcting the aim by first impacts.

    Restitution and penetration, the greatest depth in radii, are medians over the
    impacts.
    """
    rng = np.random.default_rng(0)
    turns = random_turns(rng, IMPACTS)
    phases = rng.random(IMPACTS)
    aim = restitution
    depth = penetration
    for _ in range(CORRECTIONS + 1):
        softness = contact(aim, depth, steps)
        plate.soften(softness)
        impacts = np.array(list(map(plate.first_impact, turns, phases)))
        deepest, ratio = np.median(impacts, axis=0).tolist()
        aim = min(max(aim * restitution / ratio, 0.05), 0.99)
        depth *= penetration / deepest
    return softness


def drop_in_mujoco(
    plate: Plate, softness: Contact, drops: int, seed: int
) -> tuple[float, NDArray[np.int64]]:
    """Drop the part with a contact.

    Returns
    -------
    seconds : float
        Inside `mj_step` only; the model is compiled and the contact chosen before.
    index : (drops,) array of int
        Stable pose, as in `resting_poses`, that each drop ended in.
    """
    plate.soften(softness)
    seconds, index = zip(
        *map(plate.drop, random_turns(np.random.default_rng(seed), drops)), strict=True
    )
    return sum(seconds), np.array(index)


HEIGHT = 20.0
CHECK_EVERY = 50
"""Steps between checks of the energy; the checks are not timed."""
LONGEST = 2000.0
"""Time after which a drop counts as failed: the step is too long for the contact."""

_XML = """<mujoco><option gravity="0 0 -1" integrator="implicitfast"/>
<asset><mesh name="hull" vertex="{}"/></asset>
<worldbody><geom type="plane" size="1 1 1" condim="1"/><body><freejoint/>
<inertial pos="0 0 0" mass="1" diaginertia="{}"/>
<geom type="mesh" mesh="hull" condim="1"/></body></worldbody></mujoco>"""


def available() -> bool:
    """Whether MuJoCo can be imported."""
    return find_spec("mujoco") is not None


class Plate:
    """A part, in its principal axes, over MuJoCo's plane."""

    def __init__(
        self, part: Part, cluster_tolerance: float = DEFAULT_CLUSTER_TOLERANCE
    ) -> None:
        if not available():
            raise ModuleNotFoundError(
                "this comparison needs MuJoCo: pip install mujoco"
            )
        self.engine: Any = import_module("mujoco")
        resting = resting_poses(part, cluster_tolerance, 0)
        body = resting.body
        equilibria = resting.equilibria
        groups = resting.clusters
        self.moment, self.axes = np.linalg.eigh(
            part.inertia / (part.mass * body.radius**2)
        )
        self.axes[:, 0] *= np.linalg.det(self.axes)
        self.points = body.points @ self.axes
        self.nearness = body.arrays.normal @ self.axes / body.arrays.distance[:, None]
        stable = equilibria.rank[equilibria.arrays.basin]
        self.pose = groups.pose[stable]
        self.decided = groups.exit_level[self.pose]
        numbers = (
            " ".join(map(repr, values.ravel().tolist()))
            for values in (self.points, self.moment)
        )
        self.model = self.engine.MjModel.from_xml_string(_XML.format(*numbers))
        self.data = self.engine.MjData(self.model)

    def soften(self, softness: Contact) -> None:
        """Set the contact and the time step; an impedance near 1 makes the contact
        exact.
        """
        self.model.geom_solref[:] = -softness.stiffness, -softness.damping
        self.model.geom_solimp[:] = 0.9999, 0.9999, 0.001, 0.5, 2.0
        self.model.opt.timestep = softness.step

    def release(self, turn: Array, height: float, speed: float) -> Array:
        """Put the part at a height, falling without turning; return the vertices'
        heights.
        """
        self.engine.mj_resetData(self.model, self.data)
        self.data.qpos[:] = 0.0, 0.0, height, *turn
        self.data.qvel[2] = -speed
        return np.asarray(self.points @ self.vertical() + height)

    def vertical(self) -> Array:
        """Vertical direction in body axes."""
        w, x, y, z = self.data.qpos[3:].tolist()
        return np.array(
            (2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y))
        )

    def first_impact(self, turn: Array, phase: float) -> tuple[float, float]:
        """Greatest depth and restitution at the end of a fall from 20 radii.

        The fall itself is exact; `phase` (0 to 1) is the place of the impact in its
        time step.
        """
        heights = self.release(turn, 0.0, 0.0)
        vertex = int(np.argmin(heights))
        speed = math.sqrt(2.0 * (HEIGHT + heights[vertex]))
        self.release(
            turn, phase * speed * self.model.opt.timestep - heights[vertex], speed
        )
        depth = 0.0
        touched = False
        while not touched or heights[vertex] < 0.0:
            self.engine.mj_step(self.model, self.data)
            heights = self.points @ self.vertical() + self.data.qpos[2]
            depth = max(depth, -heights.min())
            touched = touched or heights[vertex] < 0.0
        turning = np.cross(self.data.qvel[3:], self.points[vertex]) @ self.vertical()
        return float(depth), float((self.data.qvel[2] + turning) / speed)

    def drop(self, turn: Array) -> tuple[float, int]:
        """Drop until the energy is too low for a way out of the pose; seconds and pose.

        While vertices are pressed in, the energy in up to three springs counts. A spin
        about the vertical does not: it should be zero, but grows with MuJoCo's errors
        and never ends.
        """
        seconds = 0.0
        chunks = 0
        mj_step = self.engine.mj_step
        model = self.model
        data = self.data
        self.release(turn, HEIGHT, 0.0)
        spring = -1.5 * float(model.geom_solref[0, 0])
        while (
            chunks * CHECK_EVERY * model.opt.timestep < LONGEST
        ):  # data.time may start anew
            begin = time.process_time()
            mj_step(model, data, nstep=CHECK_EVERY)
            seconds += time.process_time() - begin
            chunks += 1
            direction = -self.vertical()
            height = data.qpos[2]
            velocity = data.qvel
            face = int(np.argmax(self.nearness @ direction))
            depth = max(0.0, (self.points @ direction).max() - height)
            spin = (self.moment * direction) @ velocity[3:]
            energy = (
                height
                + spring * depth**2
                + 0.5 * velocity[2] ** 2
                + 0.5 * self.moment @ velocity[3:] ** 2
                - 0.5 * spin**2 / (self.moment @ direction**2)
            )
            if energy < self.decided[face]:
                return seconds, int(self.pose[face])
        raise RuntimeError(
            f"a drop was still going on after {LONGEST:g} sqrt(radius / g)"
        )


def random_turns(rng: np.random.Generator, count: int) -> Array:
    """Uniform random orientations as quaternions w x y z (count, 4)."""
    turns = rng.standard_normal((count, 4))
    return np.asarray(turns / np.linalg.norm(turns, axis=1)[:, None])
