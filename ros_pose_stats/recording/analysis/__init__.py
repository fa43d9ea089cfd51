"""Bags read and analysed, whoever recorded them."""

from ...records.scene import Numbering
from .bag_reader import BagContents, BagFile, PartRecord, read_bags, read_part_meshes
from .camera_counts import CameraCounts
from .comparisons import (
    BagAnalysis,
    Comparison,
    CountComparison,
    PartAnalysis,
    SimulationComparison,
    analyse,
    analyse_bags,
)
from .jobs import Job
from .results import PoseTable, Prediction, ResultHistory

__all__ = ["BagAnalysis", "BagContents", "BagFile", "CameraCounts", "Comparison",
           "CountComparison", "Job", "Numbering", "PartAnalysis", "PartRecord", "PoseTable",
           "Prediction", "ResultHistory", "SimulationComparison", "analyse",
           "analyse_bags", "read_bags", "read_part_meshes"]
