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

"""Parameters of ROS by the table of settings: declared, checked, and kept at a time."""

import threading
from collections.abc import Callable, Sequence
from dataclasses import Field
from difflib import get_close_matches
from typing import Any

from rcl_interfaces import msg
from rclpy.node import Node
from rclpy.parameter import Parameter

from ...base.errors import PoseStatsError, RequestError
from .table import TABLE, Settings, settings_of

TYPES = {
    bool: Parameter.Type.BOOL,
    int: Parameter.Type.INTEGER,
    float: Parameter.Type.DOUBLE,
    str: Parameter.Type.STRING,
    tuple: Parameter.Type.STRING_ARRAY,
}

PLATE = {"plate", "plates"}  # what the profile of the plate hangs on


class Parameters:
    """Declares the parameters, refuses bad values and keeps a snapshot.

    The file of plates is read whenever `plate` or `plates` is set, be it to the same
    value.
    """

    def __init__(self, node: Node, on_change: Callable[[Settings], object]) -> None:
        values = _declare(node)
        _warn_of_unknown(node)
        self.settings = settings_of(values)
        self._node = node
        self._on_change = on_change
        self._checked = threading.local()
        self._lock = threading.Lock()
        node.add_pre_set_parameters_callback(
            lambda parameters: list(map(_widen, parameters))
        )
        node.set_parameters(
            [
                Parameter(name, _kind(TABLE[name]), value)
                for name, value in values.items()
            ]
        )
        # Bounds at last: the refusals of `settings_of` say more.
        for setting in TABLE.values():
            node.set_descriptor(setting.name, _descriptor(setting))
        node.add_on_set_parameters_callback(self._check)
        node.add_post_set_parameters_callback(self._apply)

    def use_plate(self, name: str) -> None:
        """Set the parameter `plate`, and read what the file of plates says of it."""
        (result,) = self._node.set_parameters(
            [Parameter("plate", Parameter.Type.STRING, name)]
        )
        if not result.successful:
            raise RequestError(
                "a plate that the node can use",
                result.reason,
                "set the parameters plate and plates",
            )

    def _check(self, parameters: Sequence[Parameter]) -> msg.SetParametersResult:
        try:
            changes = _own_values(parameters)
            values = vars(self.settings) | changes
            if PLATE & changes.keys():
                del values["profile"]
            self._checked.settings = settings_of(values)
            for name in changes:
                if TABLE[name].metadata["fixed"]:
                    raise RequestError(
                        f"{name} to be set at the start only",
                        f"{changes[name]!r}",
                        "start the node again",
                    )
        except PoseStatsError as refusal:
            return msg.SetParametersResult(successful=False, reason=str(refusal))
        return msg.SetParametersResult(successful=True)

    def _apply(self, parameters: Sequence[Parameter]) -> None:
        changes = _own_values(parameters)
        if not changes:
            return
        with self._lock:
            values = vars(self.settings) | changes
            if PLATE & changes.keys():
                # The file may be another one by now than when it was checked.
                values["profile"] = self._checked.settings.profile
            self.settings = settings_of(values)
        self._on_change(self.settings)


def _declare(node: Node) -> dict[str, Any]:
    """Declare the parameters, still without bounds; their values."""
    values = {}
    for name, setting in TABLE.items():
        descriptor = msg.ParameterDescriptor(name=name, dynamic_typing=True)
        parameter = node.declare_parameter(name, setting.default, descriptor, False)
        values[name] = _value(setting, _widen(parameter))
    return values


def _warn_of_unknown(node: Node) -> None:
    """Warn of values that were given for parameters that there are not."""
    for name in node._parameter_overrides:  # which rclpy shows in no other way
        if not node.has_parameter(name) and not name.startswith("qos_overrides."):
            like = get_close_matches(name, TABLE, 1)
            hint = f"; did you mean {like[0]}?" if like else ""
            node.get_logger().warning(
                f"there is no parameter '{name}', its value is ignored{hint}"
            )


def _kind(setting: Field[Any]) -> Parameter.Type:
    return TYPES[type(setting.default)]


def _descriptor(setting: Field[Any]) -> msg.ParameterDescriptor:
    kind = _kind(setting)
    metadata = setting.metadata
    descriptor = msg.ParameterDescriptor(
        name=setting.name,
        type=kind.value,
        dynamic_typing=True,
        description=metadata["description"],
        additional_constraints="set at the start only" if metadata["fixed"] else "",
    )
    if metadata["bounds"] and kind is Parameter.Type.DOUBLE:
        low, high = map(float, metadata["bounds"])
        descriptor.floating_point_range = [
            msg.FloatingPointRange(from_value=low, to_value=high)
        ]
    elif metadata["bounds"]:
        lowest, highest = map(int, metadata["bounds"])
        descriptor.integer_range = [
            msg.IntegerRange(from_value=lowest, to_value=highest, step=1)
        ]
    return descriptor


def _widen(parameter: Parameter) -> Parameter:
    setting = TABLE.get(parameter.name)
    if setting is None:
        return parameter
    if isinstance(setting.default, float) and parameter.type_ is Parameter.Type.INTEGER:
        return Parameter(parameter.name, Parameter.Type.DOUBLE, float(parameter.value))
    if isinstance(setting.default, tuple) and not parameter.value:
        return Parameter(parameter.name, Parameter.Type.STRING_ARRAY, [])
    return parameter


def _value(setting: Field[Any], parameter: Parameter) -> Any:
    kind = _kind(setting)
    if parameter.type_ is not kind:
        raise RequestError(
            f"{setting.name} as {kind.name.lower()}",
            f"{parameter.value!r}",
            f"{setting.default!r} is the default",
        )
    value = parameter.value
    return tuple(value) if isinstance(setting.default, tuple) else value


def _own_values(parameters: Sequence[Parameter]) -> dict[str, Any]:
    return {
        parameter.name: _value(TABLE[parameter.name], parameter)
        for parameter in parameters
        if parameter.name in TABLE
    }
