"""Figures, each a small function on records or arrays; with matplotlib and pillow."""

from ...base.extras import require_modules

require_modules("matplotlib", "PIL")
