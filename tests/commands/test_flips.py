"""`flips`: the matrix, what a feeder gets, the JSON object, and refusals."""

from __future__ import annotations

import json

import numpy as np
import pytest

from ros_pose_stats import cli, load_part, shapes, simulate_flips
from tests.bodies import write_stl


@pytest.fixture(scope="module")
def box(tmp_path_factory):
    """A box 20 x 30 x 40, in millimetres."""
    path = tmp_path_factory.mktemp("parts") / "box.stl"
    write_stl(path, shapes.box(20.0, 30.0, 40.0))
    return str(path)


def run(capsys, *arguments):
    status = cli.main(["flips", *map(str, arguments)])
    return status, *capsys.readouterr()


def test_the_object_is_the_library_s(box, capsys):
    status, out, _ = run(capsys, box, "--unit", "mm", "--kick", 0.02, "--flips", 50, "--seed", 5,
                         "--json")
    found = json.loads(out)
    expected = simulate_flips(load_part(box, unit="mm"), 0.02, 50, seed=5).as_dict()
    for name in ("seconds", "part_id"):
        found.pop(name), expected.pop(name)
    assert status == 0 and found == expected
    np.testing.assert_allclose(np.sum(found["transition"], axis=1), 1.0)


def test_feeding(box, capsys):
    options = box, "--unit", "mm", "--kick", 0.05, "--flips", 200, "--seed", 5, "--wanted", "0,1"
    feeding = json.loads(run(capsys, *options, "--json")[1])["feeding"]
    again, kicked = feeding["dropped_again"], feeding["kicked"]
    assert again["per_minute"]["value"] == pytest.approx(60.0 * again["accepted"]["value"])
    assert kicked["accepted"]["value"] == 1.0 and kicked["flips"]["value"] > 0.0
    for number in (*again.values(), *kicked.values()):
        assert number["low"] <= number["value"] <= number["high"]
    lines = run(capsys, *options)[1].splitlines()
    assert lines[0] == "box: kicked by 50 mm on a frictionless plate, restitution 0.5"
    assert any(line.strip().startswith("kicked") for line in lines)


@pytest.mark.parametrize("way", [("--kick", 0.05), ("--sweep", 0.05)])
def test_wanted_poses_of_which_symmetry_has_more(box, capsys, way):
    options = box, "--unit", "mm", *way, "--flips", 20, "--drops", 100, "--seed", 5, "--wanted", 0
    said = "WANTED_ALIKE: pose 1 looks the same as pose 0"
    assert said in run(capsys, *options)[1]
    assert said in json.loads(run(capsys, *options, "--json")[1])["warnings"][-1]


class TestSweep:
    OPTIONS = ("--unit", "mm", "--flips", 60, "--drops", 500, "--seed", 5, "--wanted", "0,1")

    def test_the_object(self, box, capsys):
        status, out, _ = run(capsys, box, *self.OPTIONS, "--sweep", 0.001, 0.02, 0.05, "--json")
        found = json.loads(out)
        assert status == 0 and [one["kick_height"] for one in found["kicks"]] == [
            0.001, 0.02, 0.05]
        assert found["kicks"][0]["feeding"]["flips"] == {"value": None, "low": None, "high": None}
        rates = [one["feeding"]["per_minute"]["value"] for one in found["kicks"]]
        assert found["best"] == found["kicks"][rates.index(max(rates))]["kick_height"]
        assert found["best"] in found["near_best"] and found["wanted"] == [0, 1]
        one = run(capsys, box, *self.OPTIONS, "--kick", 0.02, "--json")[1]
        assert json.loads(one)["feeding"]["kicked"] == found["kicks"][1]["feeding"]
        assert json.loads(one)["feeding"]["dropped_again"] == found["dropped_again"]

    def test_the_table_and_the_picture(self, box, capsys, tmp_path):
        from matplotlib.image import imread

        picture = tmp_path / "kicks.png"
        status, out, _ = run(capsys, box, *self.OPTIONS, "--sweep", "--png", picture)
        lines = out.splitlines()
        assert status == 0 and lines[0].startswith("box: released")
        assert sum(line.endswith("fastest") for line in lines[:-1]) == 1
        assert "no bound" in out and "nan" not in out
        assert imread(picture).shape == (585, 960, 4)

    @pytest.mark.parametrize(("options", "words"), [
        (("--sweep",), "--wanted with --sweep"),
        (("--kick", 0.01, "--png", "kicks.png"), "--png with --sweep"),
        (("--sweep", -1.0, "--wanted", "0"), "a kick height of 0 m or more"),
        (("--sweep", "--wanted", "0", "--rate", 0), "a rate above 0"),
        (("--sweep", "--wanted", "0", "--png", "kicks.jpg"), ".png"),
    ])
    def test_refusals(self, box, capsys, options, words):
        status, out, err = run(capsys, box, "--unit", "mm", *options)
        assert (status, out) == (2, "") and words in err


def test_refusals(box, capsys):
    for options, words in ((("--kick", -1), "kick height of 0 m or more"),
                           (("--kick", 0.01, "--wanted", 9), "wanted poses out of 0 to 5")):
        status, out, err = run(capsys, box, "--unit", "mm", "--flips", 20, "--drops", 20,
                               *options)
        assert (status, out) == (2, "") and words in err
