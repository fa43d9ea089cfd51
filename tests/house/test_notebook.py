"""The notebook in docs is that of its cells, and they run."""

from __future__ import annotations

import json

import pytest

from tests.house.clamp_notebook import CELLS, NOTEBOOK, run_code


def test_the_notebook_holds_the_cells_with_their_outputs():
    whole = json.loads(NOTEBOOK.read_text(encoding="utf-8"))
    assert (whole["nbformat"], whole["nbformat_minor"]) == (4, 5)
    assert [(cell["cell_type"], "".join(cell["source"])) for cell in whole["cells"]] == list(CELLS)
    assert all(cell["outputs"] for cell in whole["cells"]
               if cell["cell_type"] == "code")
    assert NOTEBOOK.stat().st_size < 300_000


@pytest.mark.long
def test_its_cells_run():
    names = {}
    printed = "".join(run_code(text, names)[0] for kind, text in CELLS if kind == "code")
    assert names["best"].gain.low > 0.0
    assert "pose 0 of the hull as it is read again" in printed
