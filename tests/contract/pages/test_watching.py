# Copyright 2026 ros_pose_stats authors
#
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this
# file except in compliance with the License. You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software distributed under
# the License is distributed on an "AS IS" BASIS, WITHOUT WARRANTIES OR CONDITIONS OF
# ANY KIND, either express or implied. See the License for the specific language
# governing permissions and limitations under the License.

"""`report --watch`: the page that follows a file, and who may see it."""

import socket

import pytest

from lab.bodies import shapes
from tests.answers import write_stl
from tests.running import answer_json, refusal

from .watching import WatchingCommand

BOX = (20.0, 30.0, 40.0)
LOW_BOX = (20.0, 30.0, 29.0)
"""The sides of 20 x 30 mm are poses 4 and 5 of the first, and 2 and 3 of the other."""


def save(file, *sides):
    """Save a box as careful programs do: under another name, then renamed."""
    write_stl(file.with_suffix(".new"), shapes.box(*sides))
    file.with_suffix(".new").replace(file)


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    return tmp_path_factory.mktemp("watched") / "<b>ox.stl"


@pytest.fixture(scope="module")
def watching(file):
    """A command that follows a file, which it had to wait for."""
    command = WatchingCommand(file, "--wanted", "4,5", "--cad", "freecad")
    assert "There is no file" in command.news()["html"]
    save(file, *BOX)
    assert "version 1: 6 poses, accepted " in command.line()
    yield command
    assert command.end() == (0, "")


@pytest.fixture(autouse=True)
def box(watching, file):
    """The first version is there, and shown."""
    save(file, *BOX)
    watching.news_with("20 × 30 × 40")


@pytest.mark.parametrize(
    "request_of",
    [
        lambda command: command.ask(Host="example.org"),
        lambda command: command.ask(Host="127.0.0.1"),
        lambda command: command.ask("news", Host=f"rebound.example:{command.port}"),
        lambda command: command.ask(path="/"),
        lambda command: command.ask(path="/news?after=-1"),
        lambda command: command.ask(path=f"/{'x' * 32}/"),
        lambda command: command.ask(path=f"{command.path[:-2]}/"),
        lambda command: command.ask("../"),
        lambda command: command.ask("watching.py"),
        lambda command: command.ask("news?after=x"),
        lambda command: command.ask(method="POST"),
        lambda command: command.ask(method="OPTIONS", Origin="http://example.org"),
        lambda command: command.ask(method="DELETE"),
    ],
)
def test_who_does_not_name_host_and_token_or_sends_something_is_refused(
    watching, request_of
):
    reply = request_of(watching)
    assert reply.status in (400, 403, 404, 501)
    assert "Access-Control-Allow-Origin" not in reply.headers
    assert "ox" not in reply.content and watching.path not in reply.content


def test_the_page_may_load_its_script_and_news_alone(watching):
    page = watching.ask()
    assert page.status == 200 and "&lt;b&gt;ox.stl" in page.content
    policy = page.headers["Content-Security-Policy"]
    assert "default-src 'none'" in policy and "script-src 'self'" in policy
    assert "frame-ancestors 'none'" in policy
    assert page.headers["Access-Control-Allow-Origin"] is None
    assert watching.ask("script.js").status == 200
    assert watching.ask(Host=f"localhost:{watching.port}").status == 200


def test_it_listens_on_one_address_of_this_machine(watching):
    with pytest.raises(ConnectionRefusedError):
        socket.create_connection(("127.0.0.2", watching.port))


def test_so_many_clients_and_no_more_are_answered(watching):
    silent_clients = [
        socket.create_connection(("127.0.0.1", watching.port)) for _ in range(16)
    ]
    try:
        assert watching.ask().status == 503
    finally:
        for client in silent_clients:
            client.close()
    while watching.ask().status == 503:
        pass  # until the server has noticed


def test_a_save_is_shown_with_what_it_changed(watching, file):
    """The wanted side is followed, whatever its number."""
    before, after = (
        sum(pose["probability"] for pose in poses if pose["index"] in wanted)
        for sides, wanted in ((BOX, (4, 5)), (LOW_BOX, (2, 3)))
        for poses in [_estimate(file, sides)["poses"]]
    )
    save(file, *BOX)
    watching.news_with("20 × 30 × 40")
    save(file, *LOW_BOX)
    news = watching.news_with("20 × 30 × 29")
    change = f"{100.0 * before:.1f} → {100.0 * after:.1f}\xa0%"
    assert "Since the last version" in news["html"] and change in news["html"]
    assert news["view"] and "accepted" in news["title"]
    assert watching.news(version=news["version"])["view"] == ""


def _estimate(file, sides):
    """The quick estimate of a box."""
    save(file.with_name("other.stl"), *sides)
    return answer_json(
        "estimate", file.with_name("other.stl"), "--unit", "mm", "--method", "split"
    )


def test_drops_sharpen_the_numbers_while_the_file_rests(watching, file):
    save(file, *LOW_BOX)
    quick = watching.news_with("20 × 30 × 29")
    assert "an estimate" in quick["html"] or " drops" in quick["html"]
    sharp = watching.news_with(" drops")
    assert sharp["version"] == quick["version"] and sharp["number"] > quick["number"]


@pytest.mark.parametrize("content", ["half", "empty", "text"])
def test_what_cannot_be_read_keeps_the_page_and_is_said(watching, file, content):
    whole = file.read_bytes()
    file.write_bytes(
        {"half": whole[: len(whole) // 2], "empty": b"", "text": b"Dear all,"}[content]
    )
    kept = watching.news_with("is not shown: expected")
    assert "20 × 30 × 40" in kept["html"]
    file.write_bytes(whole)
    mended = watching.news(kept["number"])
    assert "is not shown" not in mended["html"]
    assert mended["version"] == kept["version"]


def test_saves_that_come_faster_than_they_can_be_shown_end_with_the_last(
    watching, file
):
    for height in range(41, 71):
        save(file, 20.0, 30.0, height)
    watching.news_with("20 × 30 × 70")


def test_poses_that_come_and_go_are_said(watching, file):
    """None of the eight faces of an octahedron is like one of the box."""
    vertices, triangles = shapes.octahedron()
    write_stl(file, (30.0 * vertices, triangles))
    news = watching.news_with("8 stable poses")
    assert " are new, " in news["html"] and " gone" in news["html"]
    assert "2 wanted poses of the first version are gone" in news["html"]
    assert news["title"].startswith("0.0 % accepted")
    save(file, *BOX)
    returned = watching.news_with("20 × 30 × 40")
    assert "of the first version" not in returned["html"]
    assert not returned["title"].startswith("0.0 %")


def test_lines_for_a_cad_system_are_printed_first(watching, file):
    *program, waiting = watching.first_lines
    lines = "\n".join(program)
    compile(lines, "lines", "exec")
    assert "slotRecomputedDocument" in lines and repr(str(file)) in lines
    assert waiting.startswith("There is no file")


def test_lines_for_a_cad_system_are_of_a_file_that_it_writes(tmp_path):
    words = "--watch", "--cad", "cadquery"
    assert ".stl, .step or .stp" in refusal("report", tmp_path / "part.obj", *words)


def test_a_file_that_is_no_part_at_the_start_is_refused(tmp_path):
    (tmp_path / "letter.stl").write_text("Dear colleague,")
    line = refusal("report", tmp_path / "letter.stl", "--watch", "--no-browser")
    assert "letter.stl" in line


def test_a_port_that_is_taken_is_refused(watching, file):
    line = refusal("report", file, "--watch", "--no-browser", "--port", watching.port)
    assert "a port that is free" in line
