"""The table of settings as ROS parameters of a node."""

import threading
from collections.abc import Callable, Sequence
from difflib import get_close_matches
from typing import Any

from rcl_interfaces import msg
from rclpy.node import Node
from rclpy.parameter import Parameter

from ..errors import PoseStatsError, RequestError
from .settings import BY_NAME, TABLE, Setting, Settings, settings_of

TYPES = {bool: Parameter.Type.BOOL, int: Parameter.Type.INTEGER, float: Parameter.Type.DOUBLE,
         str: Parameter.Type.STRING, list: Parameter.Type.STRING_ARRAY}

PLATE = {"plate", "plates"}  # what the profile of the plate hangs on


class Parameters:
    """Declares the parameters, refuses bad values and keeps a snapshot.

    The file of plates is read whenever `plate` or `plates` is set, be it to the same value.
    """

    def __init__(self, node: Node, on_change: Callable[[Settings], object]) -> None:
        values = {setting.name: _value(setting, _widened(node.declare_parameter(
            setting.name, setting.default, msg.ParameterDescriptor(
                name=setting.name, dynamic_typing=True), False))) for setting in TABLE}
        for name in node._parameter_overrides:  # which rclpy shows in no other way
            if not node.has_parameter(name) and not name.startswith("qos_overrides."):
                like = get_close_matches(name, BY_NAME, 1)
                hint = f"; did you mean {like[0]}?" if like else ""
                node.get_logger().warning(
                    f"there is no parameter '{name}', its value is ignored{hint}")
        self.settings = settings_of(values)
        self._node, self._on_change = node, on_change
        self._checked = threading.local()
        self._lock = threading.Lock()
        node.add_pre_set_parameters_callback(lambda given: list(map(_widened, given)))
        node.set_parameters([Parameter(setting.name, TYPES[type(setting.default)],
                                       values[setting.name]) for setting in TABLE])
        for setting in TABLE:  # bounds at last: the refusals of `settings_of` say more
            node.set_descriptor(setting.name, _descriptor(setting))
        node.add_on_set_parameters_callback(self._check)
        node.add_post_set_parameters_callback(self._apply)

    def use_plate(self, name: str) -> None:
        """Set the parameter `plate`, and read what the file of plates says of it."""
        (result,) = self._node.set_parameters([Parameter("plate", Parameter.Type.STRING, name)])
        if not result.successful:
            raise RequestError("a plate that the node can use", result.reason,
                               "set the parameters plate and plates")

    def _check(self, parameters: Sequence[Parameter]) -> msg.SetParametersResult:
        try:
            ours, values = _ours(parameters), dict(vars(self.settings))
            if PLATE & ours.keys():
                del values["profile"]
            self._checked.settings = settings_of({**values, **ours})
            for name in ours:
                if BY_NAME[name].fixed:
                    raise RequestError(f"{name} to be set at the start only", f"{ours[name]!r}",
                                       "start the node again")
        except PoseStatsError as refusal:
            return msg.SetParametersResult(successful=False, reason=str(refusal))
        return msg.SetParametersResult(successful=True)

    def _apply(self, parameters: Sequence[Parameter]) -> None:
        ours = _ours(parameters)
        if not ours:
            return
        with self._lock:  # a file that was good when it was checked may be another one by now
            before = vars(self.settings)
            profile = (self._checked.settings.profile if PLATE & ours.keys()
                       else before["profile"])
            self.settings = settings_of({**before, **ours, "profile": profile})
        self._on_change(self.settings)


def _descriptor(setting: Setting) -> msg.ParameterDescriptor:
    kind = TYPES[type(setting.default)]
    descriptor = msg.ParameterDescriptor(
        name=setting.name, type=kind.value, dynamic_typing=True,
        description=setting.description,
        additional_constraints="set at the start only" if setting.fixed else "")
    if setting.bounds and kind is Parameter.Type.DOUBLE:
        low, high = map(float, setting.bounds)
        descriptor.floating_point_range = [msg.FloatingPointRange(from_value=low, to_value=high)]
    elif setting.bounds:
        least, most = map(int, setting.bounds)
        descriptor.integer_range = [msg.IntegerRange(from_value=least, to_value=most, step=1)]
    return descriptor


def _widened(parameter: Parameter) -> Parameter:
    setting = BY_NAME.get(parameter.name)
    if setting is None:
        return parameter
    if isinstance(setting.default, float) and parameter.type_ is Parameter.Type.INTEGER:
        return Parameter(parameter.name, Parameter.Type.DOUBLE, float(parameter.value))
    if isinstance(setting.default, list) and not parameter.value:
        return Parameter(parameter.name, Parameter.Type.STRING_ARRAY, [])
    return parameter


def _value(setting: Setting, parameter: Parameter) -> Any:
    wanted = TYPES[type(setting.default)]
    if parameter.type_ is not wanted:
        raise RequestError(f"{setting.name} as {wanted.name.lower()}", f"{parameter.value!r}",
                           f"{setting.default!r} is the default")
    return list(parameter.value) if isinstance(setting.default, list) else parameter.value


def _ours(parameters: Sequence[Parameter]) -> dict[str, Any]:
    return {parameter.name: _value(BY_NAME[parameter.name], parameter)
            for parameter in parameters if parameter.name in BY_NAME}
