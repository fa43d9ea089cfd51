"""Weights of expected errors, as `python -m training.expected_errors --write` stores them."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np

from .tanh_network import Array, TanhNetwork, pack_networks, round_to_digits, unpack_networks

FILE = Path(__file__).parent / "weights" / "expected_errors.npz"


class ErrorFit(NamedTuple):
    """How the square error of one method grows with what is known of the part and the scene.

    Attributes
    ----------
    lowest, highest : (K,) array
        Inputs of the fit; beyond them the answer is that for the nearest ones.
    network : TanhNetwork
    """

    lowest: Array
    highest: Array
    network: TanhNetwork

    def __call__(self, inputs: Array) -> Array:
        """Logarithm (...) of the expected square error over the mean of `error_scale`.

        Parameters
        ----------
        inputs : (..., K) array
            As from `error_inputs.error_inputs`.
        """
        return self.network(np.clip(inputs, self.lowest, self.highest))


def pack_error_fits(fits: Mapping[str, ErrorFit], usual_at: tuple[float, ...],
                    usual: Mapping[str, Array]) -> dict[str, Array]:
    """What the file holds.

    Parameters
    ----------
    fits : mapping
        By method.
    usual_at : tuple of float
        Restitutions.
    usual : mapping
        By method, the root mean square error at each of them.
    """
    return {"method": np.array(list(fits)),
            "lowest": round_to_digits(np.array([fit.lowest for fit in fits.values()])),
            "highest": round_to_digits(np.array([fit.highest for fit in fits.values()])),
            **pack_networks([fit.network for fit in fits.values()], ""),
            "usual_at": np.array(usual_at),
            "usual": np.round([usual[name] for name in fits], 3)}


with np.load(FILE) as _stored:
    _methods: list[str] = _stored["method"].tolist()

    ERROR_FITS = dict(zip(_methods, map(
        ErrorFit, _stored["lowest"], _stored["highest"], unpack_networks(_stored, "")),
        strict=True))
    """By method, of the inputs of `error_inputs.error_inputs`."""

    USUAL_AT: tuple[float, ...] = tuple(_stored["usual_at"].tolist())
    """Restitutions of the tuples below."""

    USUAL_ERRORS: dict[str, tuple[float, ...]] = {
        name: tuple(row) for name, row in zip(_methods, _stored["usual"].tolist(), strict=True)}
    """Root mean square error over the parts of the reference datasets, as a fraction."""
