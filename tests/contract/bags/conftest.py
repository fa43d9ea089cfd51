"""Nodes in a domain of their own, said to each by its environment alone."""

import pytest

# Sets discovery and checks, before ROS is imported.
import tests.contract.node.conftest  # noqa: F401


@pytest.fixture(scope="session")
def domain(tmp_path_factory):
    """The domain, and the environment of a node in it."""
    from tests.contract.node.harness.domains import own_domain

    with own_domain() as number:
        yield (
            number,
            {
                "ROS_DOMAIN_ID": str(number),
                "ROS_LOG_DIR": str(tmp_path_factory.mktemp("ros_logs")),
            },
        )
