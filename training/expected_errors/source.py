"""The module that holds the fitted expected errors."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ros_pose_stats.estimators.error_fit import ErrorFit

from ..split.source import bent_source, number_rows
from .fit import RESTITUTIONS

Array = NDArray[np.float64]

MODULE = Path(__file__).resolve().parents[2] / "ros_pose_stats/estimators/error_weights.py"


def source(fits: dict[str, ErrorFit], usual: dict[str, Array]) -> str:
    """The module that holds the weights."""
    return TEXT.format(
        "\n".join(_entry(name, fit) for name, fit in fits.items()), RESTITUTIONS,
        "\n".join(f'    "{name}": ({", ".join(f"{one:.3f}" for one in row)}),'
                  for name, row in usual.items()))


def _entry(name: str, fit: ErrorFit) -> str:
    """One method's."""
    lowest, highest = (number_rows(row, " " * 12) for row in (fit.lowest, fit.highest))
    return (f'    "{name}": ErrorFit(\n        lowest=np.array([\n{lowest}]),\n'
            f"        highest=np.array([\n{highest}]),\n"
            f"        bent={bent_source(fit.bent, 8)}),")


TEXT = '''"""Weights of expected errors by `python -m training.expected_errors --write`."""

from __future__ import annotations

from typing import Final

import numpy as np

from .bent import Bent
from .error_fit import ErrorFit

ERROR_FITS: Final[dict[str, ErrorFit]] = {{
{}
}}
"""By method, of the inputs of `error_inputs.error_inputs`."""

USUAL_AT: Final = {}
"""Restitutions of the tuples below."""

USUAL_ERRORS: Final[dict[str, tuple[float, ...]]] = {{
{}
}}
"""Root mean square error over the parts of the reference datasets, as a fraction."""
'''
