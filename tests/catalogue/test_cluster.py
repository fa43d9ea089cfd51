"""A catalogue from a dask.distributed cluster of separate processes, one of which dies."""

import os
import signal

import pytest

from ros_pose_stats.catalogue.making import make_catalogue
from ros_pose_stats.catalogue.request import CatalogueRequest, PartFile, find_parts
from tests.catalogue import boxes, here
from tests.clusters import scheduler, worker

distributed = pytest.importorskip("distributed", reason="the extra `cluster` is not installed")

from ros_pose_stats.batch.cluster import ClusterWork, work_on_cluster  # noqa: E402
from ros_pose_stats.catalogue.cluster import bundles, on_cluster  # noqa: E402

REQUEST = CatalogueRequest(unit="mm", target_error=0.01)
SIZES = [(10.0, 20.0, 30.0 + k) for k in range(120)]


def tables(folder):
    return [(folder / name).read_bytes() for name in ("catalogue.csv", "poses.csv")]


@pytest.mark.parametrize("count", [1, 7, 49, 50, 399, 400, 5000])
def test_bundles_hold_every_piece_once(count):
    pieces = [(PartFile(str(k), 0, 0), False) for k in range(count)]
    found = bundles(pieces)
    assert [piece for bundle in found for piece in bundle] == pieces
    assert max(map(len, found)) <= 8
    assert len(found) >= min(count, 50)


def test_parts_to_be_dropped_go_one_by_one():
    pieces = [(PartFile(str(k), 0, 0), True) for k in range(1000)]
    assert bundles(pieces) == [(piece,) for piece in pieces]


def die_at_three(number):
    """Work for `test_a_piece_that_kills_its_workers`."""
    return os.kill(os.getpid(), signal.SIGKILL) if number == 3 else number ** 2


@pytest.mark.long
class TestLosses:
    def test_a_worker_is_killed_midway(self, tmp_path, tmp_path_factory):
        folder = tmp_path_factory.mktemp("cluster")
        parts = boxes(tmp_path / "parts", SIZES)
        (parts / "letter.stl").write_text("Dear colleague,")
        files = find_parts([parts])
        assert make_catalogue(tmp_path / "whole", files, REQUEST, here()).complete
        with (scheduler(folder) as (_, address), worker(address) as first,
              worker(address), distributed.Client(address, set_as_default=False) as client):
            client.wait_for_workers(2, timeout=60)
            done = []

            def kill_after_ten(progress):
                done.append(progress)
                if len(done) == 10:
                    first.kill()

            made = make_catalogue(tmp_path / "out", files, REQUEST, on_cluster(address),
                                  on_progress=kill_after_ten)
        assert made.complete and len(made.tally.refused) == 1
        assert tables(tmp_path / "out") == tables(tmp_path / "whole")

    def test_a_piece_that_kills_its_workers(self, tmp_path_factory):
        """The scheduler gives up at once, so four workers die of it."""
        folder = tmp_path_factory.mktemp("cluster")
        with scheduler(folder, DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES="0") as (_, address):
            workers = [worker(address) for _ in range(6)]
            for one in workers:
                one.__enter__()
            try:
                work = ClusterWork(die_at_three, lambda number: (number,), lambda _: 1,
                                   lambda number: -number)
                found = dict(work_on_cluster(address, work, range(6), lambda: False))
            finally:
                for one in workers:
                    one.__exit__(None, None, None)
        assert found == {0: 0, 1: 1, 2: 4, 3: -3, 4: 16, 5: 25}
