"""Settings and mesh topics, without a node."""

from __future__ import annotations

import math
from pathlib import Path

import pytest
import yaml

from ros_pose_stats.errors import RequestError
from ros_pose_stats.records import DropScene
from ros_pose_stats.ros.settings import TABLE, mesh_topics, settings_of

from .contract import DEFAULTS


def settings(**changes):
    return settings_of({**DEFAULTS, **changes})


class TestBounds:
    @pytest.mark.parametrize("one", [one for one in TABLE if one.low is not None],
                             ids=lambda one: one.name)
    def test_both_ends_are_allowed_and_what_is_beyond_is_not(self, one):
        step = 1 if isinstance(one.default, int) else 1e-6 * max(abs(one.high), 1.0)
        if one.name != "mesh_unit":
            assert getattr(settings(**{one.name: one.low}), one.name) == one.low
        assert getattr(settings(**{one.name: one.high}), one.name) == one.high
        for value in (one.low - step, one.high + step):
            with pytest.raises(RequestError) as refusal:
                settings(**{one.name: value})
            assert one.name in str(refusal.value) and f"got {value}" in str(refusal.value)

    def test_nan_is_never_in_bounds(self):
        for one in TABLE:
            if isinstance(one.default, float):
                with pytest.raises(RequestError):
                    settings(**{one.name: math.nan})

    def test_method(self):
        with pytest.raises(RequestError, match="'guess'"):
            settings(default_method="guess")

    def test_folder(self):
        assert settings().directory() == Path.home() / ".ros" / "pose_stats"
        assert settings(log_directory="~/bags").directory() == Path.home() / "bags"
        with pytest.raises(RequestError, match="log_directory"):
            settings(log_directory="~nobody_of_this_name/bags")


class TestTexts:
    @pytest.mark.parametrize("name", ["plate", "plate_frame", "log_directory"])
    def test_what_would_disturb_a_terminal_or_fill_every_answer(self, name):
        assert getattr(settings(**{name: "x" * 500}), name) == "x" * 500
        for text in ("x" * 501, "brass\x1b[2J", "two\nlines"):
            with pytest.raises(RequestError, match=f"{name} of at most 500 printable"):
                settings(**{name: text})

    def test_each_of_the_topics(self):
        with pytest.raises(RequestError, match="mesh_topics"):
            settings(mesh_topics=["/cad", "x" * 501])


class TestThreads:
    def test_workers_are_as_many_as_asked_for(self):
        assert settings(workers=3).threads() == 3

    def test_but_at_most_four_a_core(self, monkeypatch):
        monkeypatch.setattr("os.sched_getaffinity", lambda _: {0, 1})
        assert settings(workers=256).threads() == 8

    @pytest.mark.parametrize(("cores", "keep", "threads"),
                             [(8, 1, 7), (8, 0, 8), (2, 1, 1), (1, 1, 1), (4, 9, 1)])
    def test_else_all_cores_but_some(self, monkeypatch, cores, keep, threads):
        monkeypatch.setattr("os.sched_getaffinity", lambda _: set(range(cores)))
        assert settings(keep_cores=keep).threads() == threads


class TestScene:
    @pytest.mark.parametrize(("scene_override", "expected"), [
        ([], (0.5, None)),
        ([(-1.0, -1.0)], (0.5, None)),
        ([(0.1, -1.0), (0.2, 3.0)], (0.1, 3.0)),
        ([(-1.0, 2.0), (0.2, 3.0)], (0.2, 2.0)),
        ([(0.0, -1.0), (0.2, -1.0)], (0.0, None)),
    ])
    def test_the_first_that_has_a_say(self, scene_override, expected):
        found = settings().scene(*scene_override)
        assert (found.restitution, found.drop_height) == expected

    def test_then_the_node(self):
        found = settings(restitution=0.3, drop_height=2.0).scene((-1.0, -1.0))
        assert (found.restitution, found.drop_height) == (0.3, 2.0)

    @pytest.mark.parametrize("scene_override", [(1.0, -1.0), (math.nan, -1.0), (-1.0, 0.0),
                                        (-1.0, math.nan), (-1.0, math.inf)])
    def test_out_of_range(self, scene_override):
        with pytest.raises(RequestError):
            settings().scene(scene_override)


GLASS = {"restitution": 0.3, "restitution_low": 0.2, "restitution_high": 0.4,
         "drop_height": 0.15, "drop_height_low": 0.1, "drop_height_high": 0.2,
         "plate_error": 0.021, "p_value": 0.5, "parts": ["box"], "counted": 300,
         "date": "2026-11-23T10:00:00+00:00", "version": "2.0"}


def plates_file(folder, **plates):
    file = folder / "plates.yaml"
    file.write_text(yaml.safe_dump({"plates": plates}))
    return str(file)


class TestPlates:
    def test_a_profile_stands_in_for_the_node_s_parameters(self, tmp_path):
        found = settings(plates=plates_file(tmp_path, glass=GLASS), plate="glass",
                         restitution=0.7, drop_height=2.0)
        scene = found.scene((-1.0, -1.0))
        assert (scene.restitution, scene.drop_height) == (0.3, 0.15)
        assert found.plate_error == 0.021

    def test_round_sides_are_the_plate_s_where_round_parts_told_them(self, tmp_path):
        told = {**GLASS, "round_sides": 96, "round_sides_low": 48, "round_sides_high": 192}
        open_ = {**GLASS, "round_sides": 96, "round_sides_low": 48, "round_sides_high": 384}
        file = plates_file(tmp_path, glass=told, open=open_, old=GLASS)
        found = {plate: settings(plates=file, plate=plate, round_sides=64).scene().round_sides
                 for plate in ("glass", "open", "old")}
        assert found == {"glass": 96, "open": 64, "old": 64}

    @pytest.mark.parametrize(("scene_override", "expected"), [
        ([(0.1, -1.0), (0.2, 3.0)], (0.1, 3.0)),
        ([(-1.0, -1.0), (0.2, -1.0)], (0.2, 0.15)),
        ([(-1.0, 1.0), (-1.0, -1.0)], (0.3, 1.0)),
    ])
    def test_request_and_part_come_first(self, tmp_path, scene_override, expected):
        found = settings(plates=plates_file(tmp_path, glass=GLASS), plate="glass")
        scene = found.scene(*scene_override)
        assert (scene.restitution, scene.drop_height) == expected

    @pytest.mark.parametrize("named", [{"plate": "glass"}, {}])
    def test_without_a_file_or_a_name_the_parameters_hold(self, tmp_path, named):
        found = settings(**named, **({} if named else {
            "plates": plates_file(tmp_path, glass=GLASS)}))
        assert (found.profile, found.plate_error, found.scene()) == (None, 0.05, DropScene())

    def test_a_file_that_is_still_to_be_written(self, tmp_path):
        assert settings(plates=str(tmp_path / "none.yaml")).profile is None

    def test_numbers_of_the_node_are_refused_all_the_same(self, tmp_path):
        with pytest.raises(RequestError, match="drop height"):
            settings(plates=plates_file(tmp_path, glass=GLASS), plate="glass", drop_height=0.0)

    @pytest.mark.parametrize(("text", "said"), [
        (None, "No such file"), ("plates: {glass", "YAML file of plates"),
        ("[1, 2]", "nothing else at its top"), ("plates: {oak: 1}", "oak"),
        ("plates: {glass: {restitution: 1.5}}", "drop_height|restitution"),
        ("", r"plate to be one of the plates in .*none"),
    ])
    def test_what_is_no_file_of_the_plate(self, tmp_path, text, said):
        file = tmp_path / "plates.yaml"
        if text is not None:
            file.write_text(text)
        with pytest.raises(RequestError, match=said) as refusal:
            settings(plates=str(file), plate="glass")
        assert "plate" in str(refusal.value) and "\n" not in str(refusal.value)

    def test_a_plate_that_is_not_in_it(self, tmp_path):
        with pytest.raises(RequestError, match=r"'glass'.*got 'oak'; .*~/fit_plate"):
            settings(plates=plates_file(tmp_path, glass=GLASS), plate="oak")

    def test_a_broken_file_is_refused_before_a_plate_is_named(self, tmp_path):
        file = plates_file(tmp_path, glass={**GLASS, "plate_error": 7.0})
        with pytest.raises(RequestError, match=r"plate_error from 0 to 1, got 7\.0 for glass"):
            settings(plates=file)


class TestMeshTopics:
    def test_ids(self):
        assert mesh_topics(["/cad/clamp", "other=/cad/clamp", "nut", "~/mine", "a=b=/c"]) == {
            "clamp": "/cad/clamp", "other": "/cad/clamp", "nut": "nut", "mine": "~/mine",
            "a=b": "/c"}

    def test_none(self):
        assert mesh_topics([]) == {}

    @pytest.mark.parametrize("entries", [
        ["/a/clamp", "/b/clamp"], ["x=/a", "x=/b"], ["/a/x", "x=/b"], ["/a", "/a"]])
    def test_one_id_twice(self, entries):
        with pytest.raises(RequestError, match="different part_id each"):
            mesh_topics(entries)

    @pytest.mark.parametrize("entry", [
        "", "/", "~", "~/", "part=", "=", "/a/", "//a", "/a//b", "a b", "/1a", "part=/ü",
        "part=~x", "a-b", "/a\n"])
    def test_what_is_no_topic(self, entry):
        with pytest.raises(RequestError, match="mesh_topics as"):
            mesh_topics([entry])

    @pytest.mark.parametrize("entry", ["x\ny=/a", "x" * 201 + "=/a"])
    def test_what_is_no_name(self, entry):
        with pytest.raises(RequestError, match="printable"):
            mesh_topics([entry])
