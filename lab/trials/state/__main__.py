"""Command line of the trials of the state."""

from ..frame import program
from . import damage, kills, owners, start

TRIALS = (
    kills.kills,
    kills.bags_that_go,
    kills.a_disk_that_is_full,
    damage.cut_files,
    damage.flipped_bytes,
    damage.flipped_bytes_read,
    owners.other_versions,
    owners.files_in_use,
    owners.a_disk_to_read_only,
    start.a_start_with_all_parts,
)
SHORT = 0.05

if __name__ == "__main__":
    raise SystemExit(program("state", TRIALS, SHORT))
