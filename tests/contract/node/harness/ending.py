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

"""The command, which prints on standard error what is there of DDS when it ends."""

import gc
import json
import os
import sys
from pathlib import Path

import rclpy

from ros_pose_stats.tools import cli

LEAVING = "/leaving"
"""The namespace of which nodes are listed."""


def main():
    """Run the command, which ends in `os._exit` after ROS has been shut down."""
    end = os._exit
    shut_down = rclpy.try_shutdown
    nodes = []

    def list_and_shut_down():
        observer = rclpy.create_node("_eye", use_global_arguments=False)
        nodes.extend(
            name
            for name, namespace in observer.get_node_names_and_namespaces()
            if namespace == LEAVING
        )
        shut_down()

    def look_and_end(status):
        gc.collect()
        print(json.dumps({"nodes": nodes, **remains()}), file=sys.stderr, flush=True)
        end(status)

    rclpy.try_shutdown = list_and_shut_down
    os._exit = look_and_end
    return cli.main()


def thread_name(file):
    """What a thread is called; nothing, if it has ended meanwhile."""
    try:
        return file.read_text()
    except (FileNotFoundError, ProcessLookupError):
        return ""


def remains():
    """Threads of the participant, and its memory that can still be opened by others."""
    threads = Path("/proc/self/task").glob("*/comm")
    locks = [
        file
        for descriptor in Path("/proc/self/fd").iterdir()
        if (file := os.path.realpath(descriptor)).startswith("/dev/shm/fastrtps_")
        and "_port" not in file
    ]
    return {
        "threads": sum(thread_name(file).startswith("dds.") for file in threads),
        "locks": len(locks),
        "memory": [lock for lock in locks if not lock.endswith(" (deleted)")],
    }


def read_remains(log):
    """What a program of this module said in its last line."""
    return json.loads(log.rstrip().splitlines()[-1])


if __name__ == "__main__":
    sys.exit(main())
