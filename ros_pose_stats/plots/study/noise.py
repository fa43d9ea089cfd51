"""What a finite number of drops alone does to a perfect estimator: the paper's Fig. 2."""

from __future__ import annotations

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.typing import ArrayLike

from .dots import axis_end, draw_dots, paired


def noise_figure(drawn: ArrayLike, simulated: ArrayLike, drops: int, noise: float) -> Figure:
    """Draw simulated probabilities against what the same number of drops makes of them.

    Parameters
    ----------
    drawn : (N,) array
        Each simulated probability redrawn: a binomial count of `drops`, divided by them.
    simulated : (N,) array
        Probabilities, 0 to 1.
    drops : int
        Of each part; n of the paper.
    noise : float
        Root mean square of the noise, Eq. 3, as a fraction of 1.

    Returns
    -------
    Figure
        One dot a stable pose, square axes, the diagonal; the noise in the title, percent.

    Raises
    ------
    RequestError
        Nothing to draw, unequal lengths, or a value that is no probability.
    """
    across, up = paired(simulated, drawn, "the noise")
    figure = Figure(figsize=(6.0, 6.2), dpi=160, layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.add_subplot()
    draw_dots(axes, across, up, axis_end(across, up), size=3.0)
    axes.set_xlabel("simulated probability")
    axes.set_ylabel(f"redrawn from it, n = {drops}")
    axes.set_title("What a perfect estimator would look like:\n"
                   f"the noise of {drops} drops is {100.0 * noise:.1f} %", fontsize=12)
    return figure
