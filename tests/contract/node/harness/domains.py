"""DDS domains in which nobody else's nodes are."""

from contextlib import contextmanager
from pathlib import Path

from domain_coordinator import domain_id

from tests.running import about

NUMBERS = range(1, 101)


def domains_in_use():
    """Domains that processes have in their environment.

    A node may live on after the run that had reserved its domain was killed.
    """
    names = (entry.name for entry in Path("/proc").glob("[0-9]*"))
    return {
        variable.removeprefix("ROS_DOMAIN_ID=")
        for name in names
        for variable in about(name, "environ").split("\0")
        if variable.startswith("ROS_DOMAIN_ID=")
    }


@contextmanager
def own_domain():
    """Reserve a domain; its number."""
    taken = domains_in_use()
    free = (number for number in NUMBERS if str(number) not in taken)
    with domain_id(free.__next__) as number:
        yield number
