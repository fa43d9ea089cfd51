"""All estimators under the names of the contract."""

from __future__ import annotations

from ..errors import RequestError
from .energy_absorption import combined, eae, meae
from .estimator import Estimator, blind
from .quasi_static import nqse, pqse, qse
from .solid_angles import adre, area, csae
from .split import split

ESTIMATORS: dict[str, Estimator] = {
    entry.name: entry
    for entry in (
        Estimator("area", "area", "section 4.B, [24]", blind(area)),
        Estimator("csae", "CSAE", "Eq. 5, [27]", blind(csae)),
        Estimator("adre", "ADRE", "section 4.B, [28], [29]", blind(adre)),
        Estimator("qse", "QSE", "section 4.B, [26]", blind(qse)),
        Estimator("pqse", "PQSE", "section 4.B, [25] in our reading", blind(pqse)),
        Estimator("nqse", "NQSE", "Eq. 6", blind(nqse)),
        Estimator("eae", "EAE", "Eqs. 7, 8", blind(eae)),
        Estimator("meae", "MEAE", "Eq. 8 with r, Appendix C", blind(meae)),
        Estimator("combined", "combined", "Eq. 9", blind(combined)),
        Estimator("split", "split", "section 4.D, weights fitted to simulations", split,
                  knows_restitution=True, knows_drop_height=True),
    )
}

DEFAULT_METHOD = "split"


def estimator(name: str) -> Estimator:
    """Look an estimator up.

    Raises
    ------
    RequestError
        If there is none of that name.
    """
    try:
        return ESTIMATORS[name]
    except KeyError:
        raise RequestError(f"a method out of {', '.join(ESTIMATORS)}", f"{name!r}",
                           "see `ros_pose_stats estimate --help`") from None
