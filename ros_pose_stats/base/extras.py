"""Modules that only some users need, and the extra of this package that brings each."""

from importlib import import_module
from typing import NamedTuple

from .errors import RequestError


class Extra(NamedTuple):
    """What brings a module, and what the module is for."""

    name: str  # as in `pip install 'ros_pose_stats[NAME]'`
    purpose: str


EXTRAS = {
    "matplotlib": Extra("tools", "draws pictures"),
    "PIL": Extra("tools", "writes pictures"),
    "jinja2": Extra("tools", "writes pages"),
    "shtab": Extra("tools", "writes what Tab completes"),
    "cascadio": Extra("step", "reads STEP files"),
    "distributed": Extra("cluster", "reaches a cluster"),
    "pyarrow": Extra("parquet", "writes Parquet files"),
}


def require_modules(*modules: str) -> None:
    """Import modules of extras.

    Raises
    ------
    RequestError
        If one of them cannot be imported; it says which extra to install.
    """
    for module in modules:
        try:
            import_module(module)
        except ImportError as error:
            raise missing_module(module, str(error)) from error


def missing_module(module: str, reason: str) -> RequestError:
    """The refusal of what needs a module that cannot be imported."""
    extra = EXTRAS[module.partition(".")[0]]
    return RequestError(
        f"the module {module}, which {extra.purpose}",
        f"none that can be imported ({reason})",
        f"install it with `pip install 'ros_pose_stats[{extra.name}]'`",
    )
