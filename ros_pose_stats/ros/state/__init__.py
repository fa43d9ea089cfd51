"""What a node must not forget, in one SQLite file; nothing of ROS is needed here."""

from .store import State
from .tables import Change, StateInUseError

__all__ = ["Change", "State", "StateInUseError"]
