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

"""The main job end to end: node, part, estimate, drops, a plate learned, bag.

Run through `make demo`. The node, the publisher, and in the end a planner and a camera
are processes of their own, as in a feeder cell.
"""

import math
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

from lab.frame.documents import markdown_table, points
from ros_pose_stats.tools.commands.terminal.running import ProgressBar

from .cell import DEMO, ROOT, Listener, end_like_ctrl_c, process, wait_for
from .learning import interval, learn_plate

PART = DEMO / "clamp.stl"
DROPS = 40_000
GOAL_SECONDS = 5.0  # after which a goal without an answer is sent again


def main() -> None:
    """Run the demo."""
    end_like_ctrl_c()
    run_command("shapes", DEMO)
    bags = DEMO / "bags"
    print("\n== the node, and a part that is sent to it ==", flush=True)
    with process(
        "ros_pose_stats",
        "node",
        "--ros-args",
        "-p",
        f"log_directory:={bags}",
        "-p",
        "restore:=false",
    ) as node:
        run_command("publish", PART, "--unit", "mm")
        listener = Listener()
        try:
            simulation, plate_picture = show_node(listener, node)
        finally:
            listener.close()
    if node.returncode != 0:
        sys.exit(f"demo: the node ended with status {node.returncode}")

    bag = max(bags.glob("pose_stats_*"))
    print("\n== the bag, read back ==", flush=True)
    run_command("bag", bag)
    page = write_report()
    pose_picture = draw_poses(simulation)
    print(f"\npicture of the poses   {pose_picture.relative_to(ROOT)}")
    print(f"picture of the plate   {plate_picture.relative_to(ROOT)}")
    print(f"bag                    {bag.relative_to(ROOT)}")
    print(f"report                 {page.relative_to(ROOT)}")


def run_command(*arguments: str | Path) -> None:
    """Run one of the package's commands until it ends."""
    command = [sys.executable, "-m", "ros_pose_stats", *map(str, arguments)]
    subprocess.run(command, cwd=ROOT, check=True)


def show_node(listener: Listener, node: subprocess.Popen[bytes]) -> tuple[Any, Path]:
    """Show the node at work: statistics of the drops, and a picture of the plate."""
    estimate = wait_for("latched estimate", lambda: listener.results("clamp"), node)[0]
    print(f"\n== {DROPS} drops through the action ==", flush=True)
    simulation = simulate(listener, "clamp", node)
    print("\n== the simulation beside the estimate ==")
    print(comparison_table(estimate, simulation))
    print(
        "\n== a planner, and a camera over another plate: counts calibrate the node ==",
        flush=True,
    )
    return simulation, learn_plate(listener, node)


def simulate(listener: Listener, part_id: str, node: subprocess.Popen[bytes]) -> Any:
    """Drop the part through the action, with a progress bar; return the statistics."""
    from rclpy.action import ActionClient
    from ros_pose_stats_msgs.action import SimulateDrops

    client = ActionClient(listener.node, SimulateDrops, "/pose_stats/simulate_drops")
    wait_for("action server", client.server_is_ready, node)

    def send_goal() -> Any:
        """Send the goal, again where the answer was lost: equal ones are one job."""
        answer = client.send_goal_async(
            SimulateDrops.Goal(part_id=part_id, drops=DROPS, seed=1),
            feedback_callback=lambda message: draw_progress(bar, message.feedback),
        )
        deadline = time.monotonic() + GOAL_SECONDS
        while not answer.done() and time.monotonic() < deadline:
            time.sleep(0.02)
        return answer.result()  # none where there is no answer

    with ProgressBar() as bar:
        result = wait_for("answer to the goal", send_goal, node).get_result_async()
        wait_for("result", result.done, node)
    response = result.result().result
    if not response.success:
        sys.exit(f"demo: {response.message}")
    return response.statistics


def draw_progress(bar: ProgressBar, feedback: Any) -> None:
    """Draw how many of the drops are done."""
    bar.draw(
        feedback.drops_done / feedback.drops_total,
        f"{feedback.drops_done} of {feedback.drops_total} drops, "
        f"{feedback.drops_per_second:.0f}/s, "
        f"expected error {100.0 * feedback.expected_error:.2f} points",
    )


def comparison_table(estimate: Any, simulation: Any) -> str:
    """The estimate beside the simulation, pose by pose."""
    estimated = {pose.index: pose.probability for pose in estimate.poses}
    head = (
        "pose",
        "group",
        "estimate %",
        "simulation %",
        "90 %",
        "drops",
        "difference",
    )
    rows = []
    squares = []
    for pose in simulation.poses:
        difference = estimated[pose.index] - pose.probability
        squares.append(difference * difference)
        rows.append(
            (
                f"{pose.index}",
                f"{pose.group}",
                points(estimated[pose.index], 2),
                points(pose.probability, 2),
                interval(pose, 2),
                f"{pose.count}",
                f"{100 * difference:+.2f}",
            )
        )
    rms = math.sqrt(sum(squares) / len(squares))
    return f"{markdown_table(head, rows)}\nrms difference {points(rms, 2)} points"


def write_report() -> Path:
    """Write the page on the clamp."""
    print("\n== the report on the clamp ==", flush=True)
    page = DEMO / "clamp.html"
    part = (PART, "--unit", "mm", "--drops", "5000")
    feeder = ("--wanted", "0", "--rate", "60")
    run_command("report", *part, *feeder, "-o", page)
    return page


def draw_poses(statistics: Any) -> Path:
    """Draw the poses with the shares of a message."""
    from ros_pose_stats import load_part
    from ros_pose_stats.node.messages.statistics_messages import statistics_of_message
    from ros_pose_stats.tools.plots.poses import poses_figure

    file = DEMO / "clamp_poses.png"
    figure = poses_figure(load_part(PART, unit="mm"), statistics_of_message(statistics))
    figure.savefig(file, dpi=110)
    return file


if __name__ == "__main__":
    main()
