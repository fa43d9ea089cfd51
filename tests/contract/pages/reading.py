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

"""What a page of HTML holds: its texts, its addresses, its pictures and what they
show.
"""

import base64
import io
import re
from html.parser import HTMLParser
from typing import NamedTuple

import numpy as np
from PIL import Image

VOID = {"meta", "link", "img", "br", "input", "hr"}


class Picture(NamedTuple):
    """What is said of it, and its file."""

    name: str
    content: bytes

    @property
    def pixels(self):
        """Of a picture of pixels (h, w, 3)."""
        return np.asarray(Image.open(io.BytesIO(self.content)).convert("RGB")).astype(
            int
        )

    @property
    def words(self):
        """Texts of a drawing, which it names beside their outlines."""
        return re.findall(r"<!-- (.*?) -->", self.content.decode())


class Page(HTMLParser):
    """A page that was read; its tags must be closed in their order."""

    def __init__(self, file):
        super().__init__()
        self.source = file.read_text(encoding="utf-8")
        self.addresses = []
        self.pictures = []
        self._texts = []
        self._open = []
        self.feed(self.source)
        assert self._open == []
        self.text = " ".join(" ".join(self._texts).replace("\xa0", " ").split())

    def handle_starttag(self, tag, attrs):
        attributes = dict(attrs)
        self.addresses += [
            attributes[name] for name in ("src", "href") if name in attributes
        ]
        if tag == "img" and attributes["src"].startswith("data:"):
            content = base64.b64decode(attributes["src"].partition(";base64,")[2])
            self.pictures.append(
                Picture(attributes.get("alt", "").replace("\xa0", " "), content)
            )
        if tag not in VOID:
            self._open.append(tag)

    def handle_endtag(self, tag):
        assert self._open.pop() == tag

    def handle_data(self, data):
        if self._open and self._open[-1] not in ("script", "style"):
            self._texts.append(data)

    def named(self, begin):
        """Pictures by the beginning of what is said of them."""
        return [picture for picture in self.pictures if picture.name.startswith(begin)]

    def needs_nothing(self):
        """Whether it asks for nothing beside itself."""
        bare = re.sub(r"base64,[^\"]*", "", self.source)
        return (
            all(address.startswith(("data:", "#")) for address in self.addresses)
            and not re.search(r"https?://(?!www\.w3\.org)", bare)
            and "default-src 'none'" in self.source
        )
