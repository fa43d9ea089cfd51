"""Numbers as people type them, and the refusals of those that are none."""

from __future__ import annotations

import pytest

from ros_pose_stats import cli


def parsed(*words):
    return cli.parser().parse_args([str(word) for word in words])


def refused(capsys, *words):
    """The one line that refuses the words."""
    with pytest.raises(SystemExit) as exit_:
        parsed(*words)
    out, err = capsys.readouterr()
    assert (exit_.value.code, out) == (2, "")
    assert err.count("\n") == 1
    return err


COUNTS = [
    ("simulate", "part.stl", "--drops"), ("simulate", "part.stl", "--seed"),
    ("simulate", "part.stl", "--workers"), ("estimate", "part.stl", "--drops"),
    ("report", "part.stl", "-o", "page.html", "--drops"),
    ("report", "part.stl", "-o", "page.html", "--seed"),
    ("animate", "part.stl", "-o", "drop.gif", "--drop"),
    ("animate", "part.stl", "-o", "drop.gif", "--seed"),
    ("dataset", "--bodies"), ("dataset", "--drops"), ("dataset", "--seed"),
    ("dataset", "--workers"), ("benchmark", "prisms", "--drops"),
    ("benchmark", "prisms", "--dice-drops"), ("benchmark", "prisms", "--seed")]


class TestCounts:
    @pytest.mark.parametrize("words", COUNTS, ids=" ".join)
    def test_every_count_may_be_in_scientific_notation(self, words, capsys):
        name = words[-1].strip("-").replace("-", "_")
        found = getattr(parsed(*words, "1e5"), name)
        assert found == 100_000
        assert type(found) is int
        assert words[-1] in refused(capsys, *words, "1.5")

    @pytest.mark.parametrize(("text", "number"), [
        ("100000", 100_000), ("1e5", 100_000), ("1E+5", 100_000), ("2.5e3", 2500), ("300.0", 300),
        ("18446744073709551615", 2 ** 64 - 1), ("-1", -1), ("-1e0", -1), ("0", 0)])
    def test_the_very_number(self, text, number):
        assert parsed("simulate", "part.stl", "--seed", text).seed == number

    @pytest.mark.parametrize("text", ["1.5", "1e-3", "nan", "inf", "-inf", "many", "", "0x10",
                                      "1 000", "1,000", "sNaN", "1e5e5"])
    def test_others_are_refused_with_what_was_expected_and_what_came(self, text, capsys):
        # An equals sign, since a word that begins with a hyphen would be an option.
        line = refused(capsys, "simulate", "part.stl", f"--drops={text}")
        expected = "a whole number, for instance 100000 or 1e5"
        assert f"--drops: expected {expected}, got '{text}'" in line

    @pytest.mark.parametrize("text", ["1e30", "1e999999999", "9" * 5000])
    def test_what_no_memory_would_hold_is_refused_at_once(self, text, capsys):
        line = refused(capsys, "simulate", "part.stl", "--drops", text)
        assert "at most 30 digits" in line
        assert len(line) < 250

    def test_a_range_is_refused_by_those_who_know_it(self, tmp_path, capsys):
        from ros_pose_stats import shapes
        from tests.bodies import write_stl

        box = write_stl(tmp_path / "box.stl", shapes.box(20.0, 30.0, 40.0))
        assert cli.main(["simulate", str(box), "--unit", "mm", "--drops", "1e10"]) == 2
        assert "expected 1 to 1000000000 drops, got 10000000000" in capsys.readouterr().err


class TestWanted:
    @pytest.mark.parametrize("words", [
        ("0", "1", "12"), ("0,1,12",), ("0,1", "12"), ("0", "1,12"), ("0 1 12",), ("0, 1, 12",),
        ("0,", "1,", "12"), ("0, 1", "12")])
    def test_commas_and_spaces(self, words):
        assert parsed("report", "part.stl", "-o", "p.html", "--wanted", *words).wanted == [
            0, 1, 12]

    @pytest.mark.parametrize("words", [("0-3",), ("0", "1-3"), ("0-1,2,3-3",), ("0\N{EN DASH}3",)])
    def test_ranges_as_tables_and_pages_write_them(self, words):
        assert parsed("sensitivity", "part.stl", "--wanted", *words).wanted == [0, 1, 2, 3]

    @pytest.mark.parametrize("text", ["3-0", "0-999999999999"])
    def test_a_range_that_is_none_or_fills_the_memory(self, text, capsys):
        assert "a range rises and has at most 100000 poses" in refused(
            capsys, "sensitivity", "part.stl", "--wanted", text)

    def test_an_option_behind_it_is_none_of_it(self):
        found = parsed("report", "--wanted", "0,1", "-o", "page.html", "part.stl")
        assert (found.wanted, found.part) == ([0, 1], "part.stl")

    def test_none_is_an_empty_list(self):
        assert parsed("report", "part.stl", "-o", "page.html").wanted == []

    @pytest.mark.parametrize("text", ["x", "0;1", "0,,1", ",", "", "0,1.5", "1e0", "nan", ",1",
                                      "0-", "0-1-2", "0-x", "0--1"])
    def test_rubbish_is_refused_with_what_was_expected_and_what_came(self, text, capsys):
        line = refused(capsys, "report", "part.stl", "-o", "p.html", "--wanted", "0", text)
        expected = "indices of poses, for instance 0,1 or 0 1 or 0-3"
        assert f"--wanted: expected {expected}, got '{text}'" in line
