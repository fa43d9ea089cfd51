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

"""Sends answers of services while other threads go on.

rclpy holds the interpreter's lock while it sends, and the middleware waits a tenth of a
second for a client that it cannot reach. So `rcl` is called here, with what rclpy would
give it.
"""

from ctypes import CDLL, PYFUNCTYPE, c_bool, c_char_p, c_void_p, py_object, pythonapi
from functools import cache
from typing import Any

from rclpy.service import Service

from ...base.errors import RequestError

# rclpy has loaded it. Several threads may call its `rcl_send_response` at once.
_rcl = CDLL("librcl.so")
_address_in = PYFUNCTYPE(c_void_p, py_object, c_char_p)(
    ("PyCapsule_GetPointer", pythonapi)
)
_create = PYFUNCTYPE(c_void_p)
_convert = PYFUNCTYPE(c_bool, py_object, c_void_p)
_destroy = PYFUNCTYPE(None, c_void_p)


def send_response(service: Service, response: Any, header: Any) -> None:
    """Send an answer to the client whose request had this header.

    Raises RequestError where the client cannot be reached, and InvalidHandle once the
    service has ended.
    """
    kind: Any = type(type(response))
    create, convert, destroy = _functions_of(kind)
    request_id = header.request_id
    # Python sees a number alone. pybind11 has the address of the C structure, which
    # names the client, behind what every object begins with.
    address = c_void_p.from_address(id(request_id) + object.__basicsize__)
    with service.handle:
        message = c_void_p(create())
        try:
            convert(response, message)
            status = _rcl.rcl_send_response(
                c_void_p(service.handle.pointer), address, message
            )
        finally:
            destroy(message)
    _rcl.rcutils_reset_error()  # else this thread prints it at the next one
    if status:
        raise RequestError(
            "a client whose quality of service fits the node's (reliable, volatile)",
            f"one that cannot be reached (status {status})",
            "check its quality of service and call again",
        )


@cache
def _functions_of(kind: Any) -> tuple[Any, Any, Any]:
    """What creates, fills and destroys a message in C, as rclpy gets at it.

    `kind`: the metaclass of the message. They are called with the lock, and raise what
    Python raises in them.
    """
    return (
        _create(_address_in(kind._CREATE_ROS_MESSAGE, None)),
        _convert(_address_in(kind._CONVERT_FROM_PY, None)),
        _destroy(_address_in(kind._DESTROY_ROS_MESSAGE, None)),
    )
