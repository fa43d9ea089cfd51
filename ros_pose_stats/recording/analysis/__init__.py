"""Bags read and analysed, whoever recorded them."""

from ...records.scene import Numbering
from .bag_reader import BagContents, read_bags, read_part_meshes
from .camera_counts import CameraCounts
from .comparisons import (
    BagAnalysis,
    Comparison,
    CountComparison,
    PartAnalysis,
    SimulationComparison,
    analyse_bags,
)
from .jobs import Job
from .results import Prediction, ResultHistory

__all__ = ["BagAnalysis", "BagContents", "CameraCounts", "Comparison", "CountComparison", "Job",
           "Numbering", "PartAnalysis", "Prediction", "ResultHistory", "SimulationComparison",
           "analyse_bags", "read_bags", "read_part_meshes"]
