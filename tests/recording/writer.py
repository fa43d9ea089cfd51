"""Writes, and says what was acknowledged, until it is killed.

    python -S -m tests.recording.writer LOG_DIRECTORY SEED THREADS MAX_BAG_BYTES

prints `ready`, waits for a line on standard input, and then a line for each acknowledged
message: its number and its SHA-256.
"""

from __future__ import annotations

import hashlib
import itertools
import os
import random
import sys
import threading
from pathlib import Path

from ros_pose_stats.recording.writer.run_log import RunLog
from tests.recording.bags import ANSWERS, EVENTS, TYPES, numbered


def write_on(log: RunLog, numbers: itertools.count, seed: int) -> None:
    chance = random.Random(seed)
    while True:
        number = next(numbers)
        size = chance.choice((10, 300, 3_000, 40_000))
        message = numbered(number, chance.randrange(size))
        durable = chance.random() < 0.7
        log.write(chance.choice((ANSWERS, EVENTS)), message, durable=durable)
        if durable:
            digest = hashlib.sha256(message).hexdigest()
            os.write(1, f"{number} {digest}\n".encode())


def main(folder: str, seed: str, threads: str, max_bag_bytes: str) -> None:
    log = RunLog(Path(folder), TYPES, max_bag_bytes=int(max_bag_bytes))
    numbers = itertools.count()
    print("ready", flush=True)
    sys.stdin.readline()
    for thread in range(int(threads)):
        threading.Thread(target=write_on, args=(log, numbers, 100 * int(seed) + thread)).start()


if __name__ == "__main__":
    main(*sys.argv[1:])
