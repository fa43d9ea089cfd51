"""The node's parameters: their table, their values at a time, and those of ROS."""

from .table import TABLE, Settings, mesh_topics

__all__ = ["TABLE", "Settings", "mesh_topics"]
