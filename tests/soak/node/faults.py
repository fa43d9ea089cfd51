"""What goes wrong around the node while it works."""

from __future__ import annotations

import resource
import time
from collections.abc import Callable
from pathlib import Path

from benchmarks.node.processes import Child

from .life import Life

FULL_SECONDS = 1.5
PEER_SECONDS = 1.0


class Surroundings:
    """The folders and the clock of a soak.

    Parameters
    ----------
    folder : Path
    """

    def __init__(self, folder: Path) -> None:
        self.bags, self.clock, self._folder = folder / "bags", folder / "clock", folder
        self.clock.write_text("0", encoding="utf-8")

    @property
    def log_directories(self) -> list[Path]:
        """Where bags are: the one in use, and those that were moved away."""
        return [*sorted(self._folder.glob("moved_*")), self.bags]

    def full_disk(self, life: Life) -> None:
        """No file may grow for a while."""
        sizes = [path.stat().st_size for path in self.bags.rglob("*.mcap")]
        self._allow(life, max(sizes, default=0))
        life.run_for(FULL_SECONDS)
        self._allow(life, resource.RLIM_INFINITY)

    def no_folder(self, life: Life) -> None:
        """Somebody moves the log directory away."""
        if self.bags.exists():
            self.bags.rename(self._folder / f"moved_{time.monotonic_ns():020d}")

    def clock_back(self, life: Life) -> None:
        """The clock is set back by another hour."""
        shift = float(self.clock.read_text(encoding="utf-8")) - 3600.0
        self.clock.write_text(f"{shift}", encoding="utf-8")

    def dead_peer(self, life: Life) -> None:
        """A client is killed in the middle of its calls."""
        with_calls = Child("tests.soak.node.peer")
        while not with_calls.seconds_to_ready and with_calls.pid:
            life.run_for(0.1)
        life.run_for(PEER_SECONDS * (0.2 + 0.8 * life.chance.random()))
        with_calls.kill()

    def faults(self) -> dict[str, Callable[[Life], None]]:
        """Those that the node outlives, by name."""
        return {"disk full": self.full_disk, "log directory moved away": self.no_folder,
                "clock set back an hour": self.clock_back,
                "client killed in a call": self.dead_peer}

    @staticmethod
    def _allow(life: Life, size: int) -> None:
        resource.prlimit(life.child.pid, resource.RLIMIT_FSIZE, (size, resource.RLIM_INFINITY))
