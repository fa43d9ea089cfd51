"""The benchmark of whole catalogues on a few parts."""

from __future__ import annotations

import pytest

from benchmarks.catalogues import measure


@pytest.mark.long
def test_processes_and_a_cluster_are_timed(tmp_path):
    section = measure(tmp_path, 8, 1)
    assert [row.name for row in section.rows] == ["processes", "dask"]
    for row in section.rows:
        assert row.cells["ratio"] == pytest.approx(row.cells["one, s"] / row.cells["two, s"])
        assert len(row.targets) == 1
