"""The node under a mixed load for minutes, while disks fill, clocks jump and processes die."""
