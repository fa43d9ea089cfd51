"""Names of methods that answer at once."""

from __future__ import annotations

from ..errors import RequestError
from ..estimators.registry import ESTIMATORS
from ..planning.best import best_method
from ..planning.hybrid import METHOD as HYBRID
from ..simulation.simulate import METHOD as SIMULATION
from .parts.part_requests import LONGEST_NAME

AUTO = "auto"
"""The most accurate estimator, with drops in the background where a target asks for them."""

METHODS = (*ESTIMATORS, AUTO)


def estimator_name(method: str, restitution: float) -> str:
    """The estimator that a name stands for.

    Parameters
    ----------
    method : str
        Out of `METHODS`.
    restitution : float
        By which `auto` chooses.

    Raises
    ------
    RequestError
        If it stands for none.
    """
    if method == AUTO:
        return best_method(restitution)
    if method in (HYBRID, SIMULATION):
        raise RequestError(f"a method that needs no drops, out of {', '.join(METHODS)}",
                           f"{method!r}", "ask for auto with a target_error, or start a drop "
                           "simulation")
    if method not in ESTIMATORS:
        raise RequestError(f"a method out of {', '.join(METHODS)}", repr(method[:LONGEST_NAME]),
                           "leave it empty for the node's")
    return method
