"""What the writing side raises when a record did not get to disk."""

from __future__ import annotations

from pathlib import Path


class RecordingError(OSError):
    """A record, or what belongs to it, could not be made safe.

    Nothing is broken for good: the next write tries again.

    Parameters
    ----------
    directory : Path
        The bag that was written to.
    cause : Exception or str
        What the operating system said, or what was wrong.
    """

    def __init__(self, directory: Path, cause: Exception | str) -> None:
        self.directory = directory
        self.cause = cause
        reason = getattr(cause, "strerror", None) or str(cause) or type(cause).__name__
        super().__init__(f"cannot record to {directory}: {reason}")
        self.errno = getattr(cause, "errno", None)

    def __reduce__(self) -> tuple[type[RecordingError], tuple[Path, str]]:
        reason = getattr(self.cause, "strerror", None) or str(self.cause)
        return type(self), (self.directory, reason)
