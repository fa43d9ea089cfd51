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

"""`catalogue` on a dask.distributed cluster of separate processes, one of which
dies.
"""

import threading
import time

import pytest

from lab.bodies import shapes
from tests.answers import write_stl
from tests.clusters import scheduler, worker
from tests.running import answer, answer_json

from .parts import TABLES


@pytest.mark.long
def test_the_tables_are_those_of_one_machine_although_a_worker_is_killed(tmp_path):
    pytest.importorskip("distributed", reason="the extra `cluster` is not installed")
    parts = tmp_path / "parts"
    output = tmp_path / "cluster"
    parts.mkdir()
    for k in range(120):
        write_stl(parts / f"box_{k}.stl", shapes.box(10.0, 20.0, 30.0 + k))
    (parts / "letter.stl").write_text("Dear colleague,")
    request = "catalogue", parts, "--unit", "mm"
    answer(*request, "-o", tmp_path / "alone")

    def kill_in_the_middle(process):
        while not list(output.rglob("*.png")):
            time.sleep(0.01)
        process.kill()

    with scheduler(tmp_path) as (_, address), worker(address) as first, worker(address):
        threading.Thread(target=kill_in_the_middle, args=(first,), daemon=True).start()
        values = answer_json(*request, "--scheduler", address, "-o", output)
        assert first.wait(60.0) != 0
    assert (values["done"], values["refused"]) == (121, 1)
    for name in TABLES:
        assert (output / name).read_bytes() == (tmp_path / "alone" / name).read_bytes()
