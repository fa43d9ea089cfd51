"""Settings of the whole suite: the same examples in every run, and no time limit on them.

`HYPOTHESIS_PROFILE=search pytest ...` tries many more, different in every run.
"""

from __future__ import annotations

import os

from hypothesis import HealthCheck, settings

COMMON = {
    "deadline": None, "database": None, "print_blob": True,
    "suppress_health_check": [HealthCheck.too_slow, HealthCheck.data_too_large],
}
settings.register_profile("fixed", derandomize=True, max_examples=60, **COMMON)
settings.register_profile("search", max_examples=3000, **COMMON)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "fixed"))
