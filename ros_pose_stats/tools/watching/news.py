# Copyright 2026 ros_pose_stats authors
#
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this
# file except in compliance with the License. You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software distributed under
# the License is distributed on an "AS IS" BASIS, WITHOUT WARRANTIES OR CONDITIONS OF
# ANY KIND, either express or implied. See the License for the specific language
# governing permissions and limitations under the License.

"""What the page shows now, and browsers that wait for it to change."""

import json
import threading
from typing import NamedTuple


class News(NamedTuple):
    """What there is to show since some moment."""

    number: int  # rises with each change
    version: int  # of the part; 0 before the first
    title: str
    html: str  # what the page says
    view: str  # JSON of the part in its poses, as of `viewer_data`; empty without part
    # base64 of the colours of its triangles, three bytes each; empty for none
    colors: str

    def as_json(self, version: int) -> bytes:
        """For a page that has the part of a version; of the same one it is left out."""
        values = self._asdict()
        if version == self.version:
            values["view"] = ""
        return json.dumps(values).encode()


class NewsBoard:
    """The latest news, for threads that wait for them."""

    def __init__(self) -> None:
        self._changed = threading.Condition()
        self._news: News | None = None
        self._is_closed = False

    def publish(
        self, version: int, title: str, html: str, view: str, colors: str = ""
    ) -> None:
        """Show this from now on."""
        with self._changed:
            number = 0 if self._news is None else self._news.number + 1
            self._news = News(number, version, title, html, view, colors)
            self._changed.notify_all()

    def wait(self, number: int, seconds: float) -> News | None:
        """News other than those of a number; None where none come in time."""
        with self._changed:
            self._changed.wait_for(
                lambda: (
                    self._is_closed
                    or (self._news is not None and self._news.number != number)
                ),
                seconds,
            )
            if self._news is None or self._news.number == number:
                return None
            return self._news

    def close(self) -> None:
        """Let nobody wait any more."""
        with self._changed:
            self._is_closed = True
            self._changed.notify_all()
