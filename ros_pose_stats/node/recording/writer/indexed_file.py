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

"""A file of a bag with chunks and an index, by mcap's own writer."""

from typing import BinaryIO

from mcap import records
from mcap.writer import Writer

from . import mcap_layout


class IndexedFile:
    """Takes schemas, channels and messages in their order.

    Their numbers are those of whoever hands them over. `contents`: what there is so
    far, by these numbers.
    """

    def __init__(self, target: BinaryIO) -> None:
        self.contents = mcap_layout.Contents()
        self._writer = Writer(target)
        self._writer.start(mcap_layout.PROFILE, mcap_layout.LIBRARY)
        self._schemas: dict[int, int] = {}  # numbers in the target by those given
        self._channels: dict[int, int] = {}

    def describe(self, record: records.Schema | records.Channel) -> None:
        """Take a schema or a channel.

        What is there already, or is of an unknown schema, is left out.
        """
        if isinstance(record, records.Schema):
            if record.id not in self._schemas:
                self.contents.schemas[record.id] = record
                self._schemas[record.id] = self._writer.register_schema(
                    record.name, record.encoding, record.data
                )
        elif record.id not in self._channels and record.schema_id in self._schemas:
            self.contents.channels[record.id] = record
            self._channels[record.id] = self._writer.register_channel(
                record.topic,
                record.message_encoding,
                self._schemas[record.schema_id],
                record.metadata,
            )

    def append(self, message: records.Message) -> None:
        """Take a message; OSError if its channel is unknown."""
        if message.channel_id not in self._channels:
            raise OSError("the description of a topic in it is damaged")
        self.contents.count(message.channel_id, message.log_time)
        self._writer.add_message(
            self._channels[message.channel_id],
            message.log_time,
            message.data,
            message.publish_time,
            message.sequence,
        )

    def finish(self, name: str) -> None:
        """Write the index and what rosbag2 keeps of a file of this name."""
        information = mcap_layout.bag_information({name: self.contents})
        self._writer.add_metadata("rosbag2", {"serialized_metadata": information})
        self._writer.finish()  # type: ignore[no-untyped-call]
