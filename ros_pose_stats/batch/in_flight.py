"""Handing out pieces of work, a few at a time, and taking each when it is done."""

from collections.abc import Callable, Generator, Hashable, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, wait
from typing import TypeVar

Piece = TypeVar("Piece", bound=Hashable)
Made = TypeVar("Made")

POLL_SECONDS = 0.05


def in_flight(submit: Callable[[Piece], Future[Made]],
              receive: Callable[[Future[Made], Piece], Made | None],
              pieces: Sequence[Piece], should_stop: Callable[[], bool],
              most: Callable[[], int]) -> Generator[tuple[Piece, Made], None, None]:
    """Hand out pieces, a few at a time, and give each as it is done.

    `receive`: takes what was made of a piece; None where it is to be handed out anew; `most`: most
    pieces that are handed out at a time; asked for each.
    """
    waiting = list(reversed(pieces))
    busy: dict[Future[Made], Piece] = {}
    while (waiting or busy) and not should_stop():
        while waiting and len(busy) < most():
            piece = waiting.pop()
            busy[submit(piece)] = piece
        for future in wait(busy, POLL_SECONDS, FIRST_COMPLETED).done:
            piece = busy.pop(future)
            made = receive(future, piece)
            if made is None:
                waiting.append(piece)
            else:
                yield piece, made
