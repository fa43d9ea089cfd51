"""What was told beside the bags and beside the library."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple

from rclpy.serialization import deserialize_message
from ros_pose_stats_msgs.msg import JobEvent, PoseStatistics

from ros_pose_stats.recording.reader.raw_reader import raw_messages
from ros_pose_stats.recording.repair.repair import repair_bags
from ros_pose_stats.recording.run_names import runs

from .bodies import estimated, prefixes, simulated
from .tally import Simulated, Tally, key_of

ENDS = (JobEvent.DONE, JobEvent.CANCELLED, JobEvent.FAILED)


class Recorded(NamedTuple):
    """What is in all bags.

    Attributes
    ----------
    bags, messages : int
    lost : int
        Results, acceptances and ends that clients were told and that are nowhere.
    unfinished : int
        Jobs that were accepted and never heard of again.
    """

    bags: int
    messages: int
    lost: int
    unfinished: int


def recorded(log_directories: Iterable[Path], tally: Tally) -> Recorded:
    """Mend the bags, read them all, and look for everything that clients were told."""
    answers, accepted, ended = set(), set(), set()
    bags = messages = 0
    for folder in log_directories:
        for repair in repair_bags(folder):
            if repair.problem:
                tally.wrong.append(repair.problem)
        for bag in runs(folder):
            bags += 1
            for message in raw_messages(bag):
                messages += 1
                if message.topic.endswith("/answers"):
                    answers.add(key_of(deserialize_message(message.data, PoseStatistics)))
                elif message.topic.endswith("/job_events"):
                    event = deserialize_message(message.data, JobEvent)
                    (ended if event.event in ENDS else accepted).add(event.job_id)
    missing = [*(tally.answers - answers), *(tally.accepted - accepted),
               *(tally.ends.keys() - ended)]
    tally.wrong += [f"told, but in no bag: {one}" for one in missing[:5]]
    return Recorded(bags, messages, len(missing), len(accepted - ended))


def compare_estimates(tally: Tally) -> int:
    """Estimates that are not those of the library."""
    bad = [key for key, found in tally.estimates if found != estimated(*key)]
    tally.wrong += [f"estimate {key} is not the library's" for key in bad[:5]]
    return len(bad)


def compare_simulations(tally: Tally) -> int:
    """Simulations whose counts are not those of the library for the same seed."""
    cut: dict[tuple[int, float, int], list[Simulated]] = defaultdict(list)
    bad = []
    for key, found in tally.simulations.items():
        if key.drops < key.asked:
            cut[key.body, key.restitution, key.seed].append(key)
        elif found != simulated(key.body, key.drops, key.restitution, key.seed):
            bad.append(key)
    for run, keys in cut.items():
        counts = prefixes(*run, [key.drops for key in keys])
        bad += [key for key in keys if tally.simulations[key] != counts[key.drops]]
    tally.wrong += [f"{key} is not the library's" for key in bad[:5]]
    return len(bad)
