"""Numbers of the prior, written by `python -m lab.training.fit_posterior`."""

FITTED_METHOD = "split"  # the estimator that they belong to
FITTED_AT = (0.2, 0.5, 0.8)  # restitutions of the rows below

FITTED = (
    (-0.3109, 0.2976, 0.0002339, 0.03047, 0.1783),
    (-0.0909, 0.2781, 2.522e-13, 0.03635, 0.2349),
    (-0.07352, 0.4204, 1.099e-05, 0.04609, 0.3199),
)
"""`PriorFit.center`, `spread`, `overrated`, `rare_below` and `unsure_share` at each."""
