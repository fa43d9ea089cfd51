"""What a node must not forget, in one SQLite file; nothing of ROS is needed here."""

from .store import State
from .tables import MESSAGES, OF_PARTS, Change, Row, StateInUseError

__all__ = ["MESSAGES", "OF_PARTS", "Change", "Row", "State", "StateInUseError"]
