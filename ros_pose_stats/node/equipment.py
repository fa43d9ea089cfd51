"""What most owners in the node work with, made before any of them."""

from collections.abc import Callable
from typing import NamedTuple

from .answering_node import AnsweringNode
from .lanes import Lanes
from .recorder import Recorder
from .refusals import Refusals
from .settings import Settings
from .state import State


class Equipment(NamedTuple):
    """It is handed to each of them as it is; `settings` gives the present ones."""

    node: AnsweringNode
    settings: Callable[[], Settings]
    state: State
    recorder: Recorder
    refusals: Refusals
    lanes: Lanes
