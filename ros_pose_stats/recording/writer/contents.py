"""What one MCAP file holds: kept while writing, filled while scanning, told in the summary."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

from mcap.records import Channel, MetadataIndex, Schema, Statistics

from .topics import Topic


@dataclass
class Contents:
    """Schemas, channels and counts of one file.

    Attributes
    ----------
    schemas, channels : dict
        By their ids.
    counts : dict
        Messages a channel id.
    start, end : int
        Log time of the first and the last message [ns]; without messages both the time of
        the file's making, where it is known.
    metadata : list of MetadataIndex
        Where the metadata records are.
    """

    schemas: dict[int, Schema] = field(default_factory=dict)
    channels: dict[int, Channel] = field(default_factory=dict)
    counts: dict[int, int] = field(default_factory=dict)
    start: int = 0
    end: int = 0
    metadata: list[MetadataIndex] = field(default_factory=list)

    @property
    def messages(self) -> int:
        """How many messages there are."""
        return sum(self.counts.values())

    def count(self, channel: int, log_time: int) -> None:
        """Take in one message."""
        self.start = min(self.start, log_time) if self.counts else log_time
        self.end = max(self.end, log_time) if self.counts else log_time
        self.counts[channel] = self.counts.get(channel, 0) + 1

    def statistics(self) -> Statistics:
        """The record that sums it up."""
        return Statistics(
            attachment_count=0, channel_count=len(self.channels),
            channel_message_counts=self.counts, chunk_count=0, message_count=self.messages,
            message_end_time=self.end, message_start_time=self.start,
            metadata_count=len(self.metadata), schema_count=len(self.schemas))

    def topics(self) -> list[Topic]:
        """The topics of its channels."""
        return [Topic(channel.topic, self.schemas[channel.schema_id].name,
                      channel.metadata.get("topic_type_hash", ""),
                      channel.metadata.get("offered_qos_profiles", "[]"))
                for channel in self.channels.values()]

    def counts_of_topics(self) -> dict[str, int]:
        """Messages a topic, also of those without any."""
        return {channel.topic: self.counts.get(number, 0)
                for number, channel in self.channels.items()}


def all_topics(files: Iterable[Contents]) -> list[Topic]:
    """The topics of several files, each once, in order of appearance."""
    return list({topic.name: topic for contents in files for topic in contents.topics()}.values())
