"""Entries of the parameter `mesh_topics`."""

from __future__ import annotations

import re
from collections.abc import Sequence

from ...errors import RequestError
from .part_requests import check_name

TOPIC = re.compile(r"(~/|/)?[A-Za-z_]\w*(/[A-Za-z_]\w*)*", re.ASCII)


def mesh_topics(entries: Sequence[str]) -> dict[str, str]:
    """Topics by the id of the part that comes on them.

    Parameters
    ----------
    entries : sequence of str
        `topic` or `part_id=topic`.

    Returns
    -------
    dict of str to str

    Raises
    ------
    RequestError
        If an entry is no topic, or two have the same id.
    """
    found: dict[str, str] = {}
    for entry in entries:
        part_id, given, topic = entry.rpartition("=")
        part_id = part_id if given else topic.rpartition("/")[2]
        if not TOPIC.fullmatch(topic) or not part_id:
            raise RequestError("mesh_topics as `topic` or `part_id=topic`", f"'{entry}'",
                               "for instance bracket=/cad/bracket")
        check_name(part_id)
        if part_id in found:
            raise RequestError("mesh_topics with a different part_id each",
                               f"'{part_id}' for {found[part_id]} and {topic}",
                               "write part_id=topic")
        found[part_id] = topic
    return found
