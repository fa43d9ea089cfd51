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

"""Sends bytes that are no requests to services, until its standard input ends.

    python -m lab.trials.fuzz.messages.raw_requests PREFIX NUMBER SEED

rclpy serialises requests itself, as every well-meaning client does. So in this process,
which is good for nothing else, the requests' types get the serialiser of a message of
plain numbers, which says nothing of its own and lets any bytes through.
"""

import ctypes
import struct
import sys
from pathlib import Path
from random import Random
from select import select

import numpy as np
import rclpy
from geometry_msgs.msg import PoseWithCovariance
from rclpy.serialization import serialize_message
from ros_pose_stats_msgs import srv

SERVICES = {
    "estimate": srv.EstimatePoses,
    "start_drop_simulation": srv.StartDropSimulation,
    "get_statistics": srv.GetStatistics,
    "forget_part": srv.ForgetPart,
    "get_drop_simulation": srv.GetDropSimulation,
    "cancel_drop_simulation": srv.CancelDropSimulation,
    "fit_plate": srv.FitPlate,
    "list_drop_simulations": srv.ListDropSimulations,
}
SIZE = 8 * (3 + 4 + 36)
"""Bytes of a PoseWithCovariance."""

CLAIMS = (1, 2, 3, 5, SIZE, 10**9, 2**28, 2**31, 2**32 - 1)
PATIENCE = 60.0
CALLBACKS = ("namespace", "name", "serialize", "deserialize", "size", "most")


def _head(name, *fields):
    """The head of a structure of rosidl: so many pointers."""
    return type(name, (ctypes.Structure,), {"_fields_": list(fields)})


# message_type_support_callbacks_t, rosidl_message_type_support_t,
# service_type_support_callbacks_t, rosidl_service_type_support_t
_Callbacks = _head("_Callbacks", *((name, ctypes.c_void_p) for name in CALLBACKS))
_Type = _head(
    "_Type", ("identifier", ctypes.c_char_p), ("data", ctypes.POINTER(_Callbacks))
)
_Members = _head(
    "_Members",
    ("namespace", ctypes.c_char_p),
    ("name", ctypes.c_char_p),
    ("request", ctypes.POINTER(_Type)),
)
_Service = _head(
    "_Service", ("identifier", ctypes.c_char_p), ("data", ctypes.POINTER(_Members))
)


def _support(package, kind, name, structure):
    """Type support of a message or service."""
    library = f"lib{package}__rosidl_typesupport_fastrtps_c.so"
    built = Path(sys.prefix) / "lib" / library
    get = getattr(
        ctypes.CDLL(str(built) if built.exists() else library),
        f"rosidl_typesupport_fastrtps_c__get_{kind}_type_support_handle__"
        f"{package}__{name}",
    )
    get.restype = ctypes.POINTER(structure)
    return get().contents.data.contents


def disguise():
    """Give all requests the serialiser of plain numbers."""
    donor = _support("geometry_msgs", "message", "msg__PoseWithCovariance", _Type)
    for kind in SERVICES.values():
        service = _support(
            "ros_pose_stats_msgs", "service", f"srv__{kind.__name__}", _Service
        )
        changed = service.request.contents.data.contents
        changed.serialize = donor.serialize
        changed.size = donor.size
        changed.most = donor.most


def payload(chance):
    """Bytes of a request that is none."""
    data = bytearray(SIZE)
    for _ in range(6):
        struct.pack_into(
            "<I", data, 4 * chance.randrange(SIZE // 4), chance.choice(CLAIMS)
        )
    claim = struct.pack("<I", chance.choice(CLAIMS)) + b"a\0" * SIZE
    return chance.choice(
        (chance.randbytes(SIZE), b"\xff" * SIZE, bytes(SIZE), claim[:SIZE], bytes(data))
    )


def message_of(data):
    """The message of numbers that are these bytes."""
    values = np.frombuffer(data, dtype="<f8")
    message = PoseWithCovariance()
    position = message.pose.position
    turn = message.pose.orientation
    position.x, position.y, position.z, turn.x, turn.y, turn.z, turn.w = values[
        :7
    ].tolist()
    message._covariance = values[7:].copy()  # the setter looks at the numbers
    return message


def main(prefix, number, seed):
    """Send so many to each service, say how many in all, and listen until the input
    ends.
    """
    disguise()
    serialize_message(PoseWithCovariance())  # loads what converts it
    rclpy.init()
    node = rclpy.create_node("stranger")
    chance = Random(seed)
    clients = [
        node.create_client(kind, f"{prefix}/{name}") for name, kind in SERVICES.items()
    ]
    if not all(client.wait_for_service(PATIENCE) for client in clients):
        raise TimeoutError("a service is not there")
    for _ in range(int(number)):
        for client in clients:
            client._Client__client.send_request(message_of(payload(chance)))
        rclpy.spin_once(node, timeout_sec=0.002)
    print(f"sent {int(number) * len(clients)}", flush=True)
    while not select([sys.stdin], [], [], 0.0)[0]:
        rclpy.spin_once(node, timeout_sec=0.05)
    rclpy.try_shutdown()


if __name__ == "__main__":
    main(*sys.argv[1:])
