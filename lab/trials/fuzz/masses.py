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

"""Mass properties to give with a polyhedron: good, nearly impossible, impossible.

Each maker takes a random generator and gives the options of `part_from_mesh`, for a
body with the given hull.
"""

from typing import Any

import numpy as np

from lab.bodies.degenerate import Random, power, rotation
from lab.bodies.shapes import Surface
from ros_pose_stats.core.records import Array

from .arrays import NUMBERS, any_object

Options = dict[str, Any]


def principal(random: Random, moments: Array) -> Array:
    """Tensor of given principal moments about random axes."""
    axes = rotation(random)
    tensor = axes @ np.diag(moments) @ axes.T
    return np.asarray(0.5 * (tensor + tensor.T))


def inside(random: Random, surface: Surface) -> Array:
    """A point well inside the hull of the vertices."""
    vertices, _ = surface
    return np.asarray(random.dirichlet(np.ones(len(vertices))) @ vertices)


def possible(random: Random, surface: Surface) -> Options:
    """Properties that a rigid part can have."""
    masses = power(random, -9, 9) * random.random(9)
    arms = random.uniform(-0.3, 0.3, (9, 3))
    square = np.einsum("m,mi,mj->ij", masses, arms, arms)
    return {
        "mass": float(masses.sum()),
        "center_of_mass": inside(random, surface),
        "inertia": np.trace(square) * np.eye(3) - square,
    }


def nearly_impossible(random: Random, surface: Surface) -> Options:
    """A centre almost on the hull, moments that almost break the triangle inequality or
    vanish.
    """
    vertices, triangles = surface
    corner = vertices[triangles[random.integers(len(triangles))]]
    shares = random.dirichlet((0.3, 0.3, 0.3))
    surface_point = shares @ corner
    toward = vertices.mean(axis=0) - surface_point
    step = power(random, -13, -1) * random.choice((1.0, 1.0, 1.0, -1.0, 0.0))
    slack = power(random, -15, -1) * random.choice((1.0, 1.0, -1.0))
    moments = (
        np.array((0.3, 0.7, 1.0 - slack))
        if random.random() < 0.5
        else np.array((abs(slack), 1.0, 1.0))
    )
    options = {"center_of_mass": surface_point + step * toward}
    if random.random() < 0.5:
        options |= {
            "mass": power(random, -300, 300),
            "inertia": power(random, -9, 9) * principal(random, moments),
        }
    return options


def _bad_mass(random: Random) -> Any:
    return random.choice((0.0, -1.0, np.nan, np.inf, -np.inf))


def impossible(random: Random, surface: Surface) -> Options:
    """Properties that no rigid part of the shape has."""
    tensor = principal(random, np.array((1.0, 2.0, 2.5)))
    lopsided = tensor + 0.1 * np.triu(np.ones((3, 3)), 1)
    outside = 3.0 * np.abs(surface[0]).max() * rotation(random)[0]
    choices: list[Options] = [
        {"mass": _bad_mass(random)},
        {"mass": "heavy"},
        {"mass": [1.0, 2.0]},
        {"mass": _bad_mass(random), "inertia": tensor},
        {"center_of_mass": outside},
        {"center_of_mass": np.full(3, np.nan)},
        {"center_of_mass": 1e300 * outside},
        {"center_of_mass": [1.0, 2.0]},
        {"center_of_mass": 0.0},
        {"center_of_mass": "here"},
        {"center_of_mass": [[1, 2], [3]]},
        {"inertia": tensor},
        {"mass": 1.0, "inertia": -tensor},
        {"mass": 1.0, "inertia": lopsided},
        {"mass": 1.0, "inertia": np.full((3, 3), np.inf)},
        {"mass": 1.0, "inertia": principal(random, np.array((1.0, 1.0, 3.0)))},
        {"mass": 1.0, "inertia": principal(random, np.array((0.0, 1.0, 1.0)))},
        {"mass": 1.0, "inertia": np.eye(4)},
        {"mass": 1.0, "inertia": np.arange(3.0)},
        {"mass": 1.0, "inertia": "round"},
        {"unit": "furlong"},
        {"unit": _bad_mass(random)},
        {"unit": [1.0]},
        {"mass": 1j},
        {"center_of_mass": np.array((1j, 0.0, 0.0))},
    ]
    return choices[int(random.integers(len(choices)))]


def one_rigid_part(_: Random, __: Surface) -> Options:
    """Bodies apart, in each other and side by side, as one rigid part."""
    return {"body": "all"}


def any_numbers(random: Random, _: Surface) -> Options:
    """A mass, a tensor and a centre of any numbers."""
    tensor = random.choice(NUMBERS, (3, 3))
    with np.errstate(all="ignore"):
        symmetric = 0.5 * tensor + 0.5 * tensor.T
    options = {
        "mass": float(random.choice(NUMBERS)),
        "center_of_mass": random.choice(NUMBERS, 3),
        "inertia": symmetric if random.random() < 0.5 else tensor,
    }
    return {name: value for name, value in options.items() if random.random() < 0.8}


def any_option(random: Random, _: Surface) -> Options:
    """Any object as one of the options."""
    names = ("mass", "center_of_mass", "inertia", "unit", "part_id")
    return {names[random.integers(len(names))]: any_object(random)}
