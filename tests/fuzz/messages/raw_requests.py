"""Sends bytes that are no requests to services: `python -m tests.fuzz.messages.raw_requests`.

    python -m tests.fuzz.messages.raw_requests PREFIX NUMBER SEED

ends with its standard input, so that nobody answers a client that is gone.

rclpy serialises requests itself, as every well-meaning client does. So in this process, which
is good for nothing else, the requests' types get the serialiser of a message of plain numbers,
which says nothing of its own and lets any bytes through.
"""

from __future__ import annotations

import ctypes
import struct
import sys
from pathlib import Path
from random import Random
from select import select
from typing import Any

import numpy as np
import rclpy
from geometry_msgs.msg import PoseWithCovariance
from rclpy.serialization import serialize_message
from ros_pose_stats_msgs import srv

SERVICES = {
    "estimate": srv.EstimatePoses, "start_drop_simulation": srv.StartDropSimulation,
    "get_statistics": srv.GetStatistics, "forget_part": srv.ForgetPart,
    "get_drop_simulation": srv.GetDropSimulation,
    "cancel_drop_simulation": srv.CancelDropSimulation,
    "list_drop_simulations": srv.ListDropSimulations}
SIZE = 8 * (3 + 4 + 36)
"""Bytes of a PoseWithCovariance."""

CLAIMS = (1, 2, 3, 5, SIZE, 10**9, 2**28, 2**31, 2**32 - 1)
HANDLE = "rosidl_typesupport_fastrtps_c__get_{}_type_support_handle__{}"
PATIENCE = 60.0


class _Callbacks(ctypes.Structure):
    """Head of `message_type_support_callbacks_t`."""

    _fields_ = [("namespace", ctypes.c_char_p), ("name", ctypes.c_char_p),
                ("serialize", ctypes.c_void_p), ("deserialize", ctypes.c_void_p),
                ("size", ctypes.c_void_p), ("most", ctypes.c_void_p)]


class _Type(ctypes.Structure):
    """Head of `rosidl_message_type_support_t`."""

    _fields_ = [("identifier", ctypes.c_char_p), ("data", ctypes.POINTER(_Callbacks))]


class _Members(ctypes.Structure):
    """Head of `service_type_support_callbacks_t`."""

    _fields_ = [("namespace", ctypes.c_char_p), ("name", ctypes.c_char_p),
                ("request", ctypes.POINTER(_Type))]


class _Service(ctypes.Structure):
    """Head of `rosidl_service_type_support_t`."""

    _fields_ = [("identifier", ctypes.c_char_p), ("data", ctypes.POINTER(_Members))]


def _handle(package: str, kind: str, name: str, structure: type) -> Any:
    """Type support of a message or service."""
    library = f"lib{package}__rosidl_typesupport_fastrtps_c.so"
    built = Path(sys.prefix) / "lib" / library
    get = getattr(ctypes.CDLL(str(built) if built.exists() else library),
                  HANDLE.format(kind, f"{package}__{name}"))
    get.restype = ctypes.POINTER(structure)
    return get().contents


def disguise() -> None:
    """Give all requests the serialiser of plain numbers."""
    donor = _handle("geometry_msgs", "message", "msg__PoseWithCovariance", _Type).data.contents
    for kind in SERVICES.values():
        service = _handle("ros_pose_stats_msgs", "service", f"srv__{kind.__name__}", _Service)
        changed = service.data.contents.request.contents.data.contents
        changed.serialize, changed.size, changed.most = donor.serialize, donor.size, donor.most


def payload(chance: Random) -> bytes:
    """Bytes of a request that is none."""
    kind = chance.randrange(5)
    if kind < 3:
        return (chance.randbytes(SIZE), b"\xff" * SIZE, bytes(SIZE))[kind]
    if kind == 3:
        return (struct.pack("<I", chance.choice(CLAIMS)) + b"a\0" * SIZE)[:SIZE]
    made = bytearray(SIZE)
    for _ in range(6):
        struct.pack_into("<I", made, 4 * chance.randrange(SIZE // 4), chance.choice(CLAIMS))
    return bytes(made)


def message_of(data: bytes) -> PoseWithCovariance:
    """The message of numbers that are these bytes."""
    values = np.frombuffer(data, dtype="<f8")
    made = PoseWithCovariance()
    place, turn = made.pose.position, made.pose.orientation
    place.x, place.y, place.z = values[:3].tolist()
    turn.x, turn.y, turn.z, turn.w = values[3:7].tolist()
    made._covariance = values[7:].copy()  # the setter looks at the numbers
    return made


def main(prefix: str, number: str, seed: str) -> None:
    """Send so many to each service, say how many in all, and listen until the input ends."""
    disguise()
    serialize_message(PoseWithCovariance())  # loads what converts it
    rclpy.init()
    node, chance = rclpy.create_node("stranger"), Random(seed)
    clients = [node.create_client(kind, f"{prefix}/{name}") for name, kind in SERVICES.items()]
    for client in clients:
        if not client.wait_for_service(PATIENCE):
            raise TimeoutError(f"no service {client.srv_name}")
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
