"""What other subscriptions than the node's do with a large mesh."""

from __future__ import annotations

from std_msgs.msg import UInt32

from ..bodies import Body
from ..results import Row, Section
from ..timing import Contender, Pace, race
from .bare import MESHES, RAW_MESHES, SIZES
from .client import Client
from .mesh_to_estimate import STANDARD, senders
from .meshes import Fresh, mesh_bytes
from .spread import spread

ORDINARY, RAW = "ordinary subscription", "raw subscription"
TOPICS = {ORDINARY: MESHES, RAW: RAW_MESHES}

TIMED = (
    "A `shape_msgs/Mesh`, already serialised, sent in turns to an ordinary (deserialising) rclpy "
    "subscription in a process of its own and to a raw one there, such as the node has, each "
    "until the callback's answer of one number is back; nothing is computed there. And to the "
    "node, until the estimate is latched. The ratio is the median over the rounds.")


def subscriptions(client: Client, body: Body, pace: Pace) -> Section:
    """The two subscriptions, and the node with estimate and all."""
    answers: list[UInt32] = []
    subscription = client.node.create_subscription(UInt32, SIZES, answers.append, 10)
    client.spin_until(lambda: client.node.count_publishers(SIZES), f"publisher of {SIZES}")
    fresh = Fresh(body)

    def contender(name: str) -> Contender:
        def send(data: bytes) -> None:
            answers.clear()
            client.publish(TOPICS[name], data)
            client.spin_until(lambda: answers, f"answer of the {name}")

        made = Contender(name, send, lambda: mesh_bytes(fresh(), body.triangles))
        made.call(made.prepare())  # the first one finds the way
        return made

    timings = race([contender(ORDINARY), contender(RAW), *senders(client, body, [STANDARD])],
                   pace)
    client.node.destroy_subscription(subscription)
    names = {ORDINARY: ORDINARY, RAW: RAW, STANDARD: "the node, to the estimate"}
    return Section("subscriptions", "Beside other subscriptions", TIMED, tuple(
        Row(f"{body.name}, {name}", {**spread(timings.seconds[key]),
                                     "ordinary / this": timings.ratio(ORDINARY, key)})
        for key, name in names.items()))
