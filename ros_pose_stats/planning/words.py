"""Sentences about how sure an answer is; those of commands, library and node are the same."""

from __future__ import annotations

LEAST_POINTS = 0.01
"""What is told of an error that symmetry makes vanish."""


def points(error: float) -> str:
    """An error as a number of points.

    Parameters
    ----------
    error : float
        A fraction.
    """
    return f"{max(100.0 * error, LEAST_POINTS):.2g} points"


def untargeted(method: str) -> str:
    """Why an estimate answers where no error was asked for."""
    return (f"{method} is expected to be the most accurate estimate of this part, and no target "
            f"error was asked for.")


def enough(what: str, bound: float, target_error: float) -> str:
    """Why an answer is kept: its bound keeps the target."""
    return (f"{what} is within {points(bound)} with 90 % confidence, and {points(target_error)} "
            f"were asked for.")


def not_enough(what: str, bound: float, target_error: float) -> str:
    """Why an answer is not: the beginning of a sentence."""
    return (f"{what} is within {points(bound)} with 90 % confidence, not within "
            f"{points(target_error)}")
