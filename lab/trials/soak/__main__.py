"""Command line of the soak: drops of many bodies, and a busy node under faults."""

from ..frame import program
from .drops import many_drops
from .node import Soak

SHORT = 0.05

if __name__ == "__main__":
    raise SystemExit(program("soak", [many_drops, *Soak().trials()], SHORT))
