"""The short page on speed: made of stored results alone, and up to date."""

from __future__ import annotations

from pathlib import Path

from benchmarks.report import STORED, render_page
from benchmarks.results import Results, Row, Section, load, save
from benchmarks.speed import Stored, chart_table, read_stored, speed_page, write_speed

DOCS = Path(__file__).resolve().parents[2] / "docs"

MACHINE = {"processor": "one", "cores": "2", "python": "3.11", "date": "2026-11-22"}


def test_the_pages_in_the_documents_are_up_to_date():
    written = (DOCS / "speed.md").read_text(encoding="utf-8")
    assert written == speed_page(read_stored(DOCS)), "run python -m benchmarks.speed"
    log = [load(DOCS / "benchmarks" / f"{name}.json") for name in STORED
           if (DOCS / "benchmarks" / f"{name}.json").exists()]
    assert (DOCS / "benchmarks.md").read_text(encoding="utf-8") == render_page(log)


def test_the_page_has_every_table():
    page = speed_page(read_stored(DOCS))
    for title in ("By size", "The demo parts", "A drop", "A wanted error", "Waiting for an answer",
                  "Machines"):
        assert f"\n## {title}\n" in page
    assert "(figures/speed_accuracy.png)" in page
    assert "clamp, 480 vertices" in page
    assert page.count("latched estimate") == 3


def test_what_is_not_stored_is_left_out(tmp_path):
    section = Section("node_start", "Start", "Timed.", (Row("node", {"ready": 1.5}),))
    save(Results(MACHINE, (section,)), tmp_path / "benchmarks" / "node.json")
    page = write_speed(tmp_path).read_text(encoding="utf-8")
    assert "| the node, from its start to `ready` | 1.5 s |" in page
    assert "## By size" not in page and "## A drop" not in page
    assert "- `benchmarks/node.json`: one, 2 cores, Python 3.11, 2026-11-22" in page


def test_methods_are_found_by_series_and_name():
    chart = {"sizes": [{"title": "small", "points": [
        {"name": "n = 100", "series": "hybrid", "seconds": 0.0102, "error": 0.0167},
        {"name": "n = 100", "series": "MuJoCo", "seconds": 4.3, "error": 0.03},
        {"name": "split", "series": None, "seconds": 0.00113, "error": 0.0212}]}]}
    lines = {line.split("|")[1].strip(): line.split("|")[2].strip()
             for line in chart_table(chart).splitlines()}
    assert lines["estimate (`split`)"] == "1.13 ms, 2.1"
    assert lines["estimate and 100 drops (`hybrid`)"] == "10.2 ms, 1.7"
    assert lines["100 drops in MuJoCo"] == "4.3 s, 3.0"
    assert lines["10 000 drops"] == "-"


def test_a_drop_is_of_the_nearest_body():
    rows = tuple(Row(f"ball, {vertices} vertices", {"vertices": vertices, "µs a drop": time})
                 for vertices, time in ((24, 40.0), (227, 90.0), (1004, 300.0), (4997, 1200.0)))
    run = Results(MACHINE, (Section("drop_growth", "Cost", "Timed.", rows),))
    page = speed_page(Stored({"drops": run}, None))
    (line,) = (line for line in page.splitlines() if line.startswith("| ball"))
    cells = [cell.strip() for cell in line.split("|")[2:5]]
    assert cells == ["90 µs (227)", "300 µs (1 004)", "1.2 ms (4 997)"]
