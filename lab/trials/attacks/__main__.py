"""Command line of the attacks."""

from ..frame import program
from . import ending, fairness, files, memory, reading

ATTACKS = (
    memory.many_large_parts,
    memory.refused_goals,
    memory.waiting_requests,
    memory.a_flood_of_meshes,
    *fairness.ATTACKS,
    ending.a_disk_that_fills,
    ending.a_flood_of_counts,
    ending.a_signal_during_an_estimate,
    ending.simulated_time_stands_still,
    files.a_clock_before_its_time,
    files.pipes_and_bombs_as_plates,
    reading.small_files_that_stand_for_much,
)
SHORT = 0.1

if __name__ == "__main__":
    raise SystemExit(program("attacks", ATTACKS, SHORT))
