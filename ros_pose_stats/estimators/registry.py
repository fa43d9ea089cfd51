"""The registry of estimators: rows of `methods` with the functions that they name."""

from collections.abc import Callable
from dataclasses import dataclass, field
from importlib import import_module

from .. import errors, methods
from ..records import Array, DropScene
from ..resting.poses import RestingPoses


@dataclass(frozen=True)
class Estimator(methods.Method):
    """A method with its function."""

    # from `RestingPoses` and `DropScene` to probabilities (P,), in the order of `index`, summing
    # to 1
    function: Callable[[RestingPoses, DropScene], Array] = field(kw_only=True)


def bind_function(method: methods.Method) -> Estimator:
    """Join a row and the function of its name, which then takes poses and scene in any case."""
    function = getattr(import_module(f".{method.module}", __package__), method.name)
    return Estimator(**vars(method), function=function if method.knows_scene
                     else lambda resting, _: function(resting))


ESTIMATORS = {method.name: bind_function(method) for method in methods.METHODS if method.module}


def estimator(name: str) -> Estimator:
    """Look an estimator up."""
    try:
        return ESTIMATORS[name]
    except KeyError:
        raise errors.RequestError(f"a method out of {', '.join(methods.AT_ONCE)}", f"{name!r}",
                                  "see `ros_pose_stats estimate --help`") from None
