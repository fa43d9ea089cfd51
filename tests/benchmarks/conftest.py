"""Messages check their fields in tests, whichever test imports them first."""

from __future__ import annotations

import os
import warnings

os.environ["ROS_PYTHON_CHECK_FIELDS"] = "1"
with warnings.catch_warnings():
    warnings.simplefilter("ignore", DeprecationWarning)  # of a parser that it imports
    import rosidl_generator_py  # noqa: F401
