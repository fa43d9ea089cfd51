"""The report on a part: one page to look at, to print and to send; with Jinja2."""

from ...base.extras import require_modules

require_modules("jinja2")
