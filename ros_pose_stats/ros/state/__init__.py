"""What a node must not forget, in one SQLite file; nothing of ROS is needed here."""

from .store import State
from .tables import MESSAGES, Change, Row, StateInUseError

__all__ = ["MESSAGES", "Change", "Row", "State", "StateInUseError"]
