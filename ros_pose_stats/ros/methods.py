"""Names of methods that answer at once."""

from __future__ import annotations

from ..errors import RequestError
from ..estimators import best_method
from ..methods import AT_ONCE, AUTO, HYBRID, SIMULATION
from .parts.part_requests import LONGEST_NAME


def estimator_name(method: str, restitution: float) -> str:
    """The estimator that a name stands for.

    Parameters
    ----------
    method : str
        Out of `AT_ONCE`.
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
        raise RequestError(f"a method that needs no drops, out of {', '.join(AT_ONCE)}",
                           f"{method!r}", "ask for auto with a target_error, or start a drop "
                           "simulation")
    if method not in AT_ONCE:
        raise RequestError(f"a method out of {', '.join(AT_ONCE)}", repr(method[:LONGEST_NAME]),
                           "leave it empty for the node's")
    return method
