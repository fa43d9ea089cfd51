"""Datasets of simulated pose statistics: random polyhedra and the counts of their
drops.
"""

from .dataset import Dataset, read_dataset, shipped_dataset, shipped_datasets
from .making import DatasetProgress, Maker, make_dataset, on_threads
from .spec import DatasetSpec

__all__ = [
    "Dataset",
    "DatasetProgress",
    "DatasetSpec",
    "Maker",
    "make_dataset",
    "on_threads",
    "read_dataset",
    "shipped_dataset",
    "shipped_datasets",
]
