"""The main job end to end: a node, a CAD part, an estimate, drops, a plate learned, the bag.

Run through `make demo`. The node, the publisher, and in the end a planner and a camera are
processes of their own, as in a feeder cell.
"""

from __future__ import annotations

import math
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

from demo_cell import DEMO, ROOT, Listener, end_like_ctrl_c, process, wait_for
from demo_learning import learn_plate

PART = DEMO / "clamp.stl"
DROPS = 40_000
COMMAND = [sys.executable, "-m", "ros_pose_stats"]


def simulate(listener: Listener, part_id: str, node: subprocess.Popen[bytes]) -> Any:
    """Drop the part through the action, with a progress bar."""
    from rclpy.action import ActionClient
    from ros_pose_stats_msgs.action import SimulateDrops

    client = ActionClient(listener.node, SimulateDrops, "/pose_stats/simulate_drops")
    wait_for("action server", client.server_is_ready, node)

    def accepted() -> Any:
        """The goal, asked for again where the answer was lost: equal ones are one job."""
        goal = client.send_goal_async(
            SimulateDrops.Goal(part_id=part_id, drops=DROPS, seed=1),
            feedback_callback=lambda message: show(message.feedback),
        )
        until = time.monotonic() + 5.0
        while not goal.done() and time.monotonic() < until:
            time.sleep(0.02)
        return goal.result()  # none where there is no answer

    coming = wait_for("answer to the goal", accepted, node).get_result_async()
    wait_for("result", coming.done, node)
    show_end()
    result = coming.result().result
    return result if result.success else sys.exit(f"demo: {result.message}")


def show(feedback: Any) -> None:
    """Draw the progress bar, or now and then a line where nobody watches."""
    share = feedback.drops_done / feedback.drops_total
    line = (
        f"[{'#' * int(24 * share):.<24}] {feedback.drops_done} of {feedback.drops_total} "
        f"drops, {feedback.drops_per_second:.0f}/s, expected error "
        f"{100.0 * feedback.expected_error:.2f} points"
    )
    if sys.stdout.isatty():
        print(f"\r{line}", end="", flush=True)
    elif time.monotonic() > show_end.next:
        show_end.next = time.monotonic() + 1.0
        print(line, flush=True)


def show_end() -> None:
    """Begin a new line after the bar."""
    if sys.stdout.isatty():
        print()


show_end.next = 0.0


def side_by_side(estimate: Any, simulation: Any) -> str:
    """The estimate beside the simulation, pose by pose."""
    estimated = {pose.index: pose.probability for pose in estimate.poses}
    lines = [
        f"{'pose':>4} {'group':>5} {'estimate %':>11} {'simulation %':>13} {'90 %':>15} "
        f"{'drops':>7} {'difference':>11}"
    ]
    squares = []
    for pose in simulation.poses:
        apart = estimated[pose.index] - pose.probability
        squares.append(apart * apart)
        interval = (
            f"{100 * pose.probability_low:.2f} - {100 * pose.probability_high:.2f}"
        )
        lines.append(
            f"{pose.index:>4} {pose.group:>5} {100 * estimated[pose.index]:>11.2f} "
            f"{100 * pose.probability:>13.2f} {interval:>15} {pose.count:>7} "
            f"{100 * apart:>+11.2f}"
        )
    rms = math.sqrt(sum(squares) / len(squares))
    return "\n".join([*lines, f"rms difference {100 * rms:.2f} points"])


def picture(statistics: Any) -> Path:
    """Draw the poses."""
    from ros_pose_stats import load_part
    from ros_pose_stats.node.messages.statistics_messages import statistics_of_message
    from ros_pose_stats.tools.plots.poses import poses_figure

    file = DEMO / "clamp_poses.png"
    figure = poses_figure(load_part(PART, unit="mm"), statistics_of_message(statistics))
    figure.savefig(file, dpi=110)
    return file


def main() -> None:
    """Run the demo."""
    end_like_ctrl_c()
    subprocess.run([*COMMAND, "shapes", str(DEMO)], cwd=ROOT, check=True)
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
        subprocess.run(
            [*COMMAND, "publish", str(PART), "--unit", "mm"], cwd=ROOT, check=True
        )
        listener = Listener()
        try:
            estimate = wait_for(
                "latched estimate", lambda: listener.results("clamp"), node
            )[0]
            print(f"\n== {DROPS} drops through the action ==", flush=True)
            result = simulate(listener, "clamp", node)
            print("\n== the simulation beside the estimate ==")
            print(side_by_side(estimate, result.statistics))
            print(
                "\n== a planner, and a camera over another plate: counts calibrate the node ==",
                flush=True,
            )
            learned = learn_plate(listener, node)
        finally:
            listener.close()
    if node.returncode != 0:
        sys.exit(f"demo: the node ended with status {node.returncode}")
    bag = max(bags.glob("pose_stats_*"))
    print("\n== the bag, read back ==", flush=True)
    subprocess.run([*COMMAND, "bag", str(bag)], cwd=ROOT, check=True)
    print("\n== the report on the clamp ==", flush=True)
    page = DEMO / "clamp.html"
    subprocess.run(
        [
            *COMMAND,
            "report",
            str(PART),
            "--unit",
            "mm",
            "--drops",
            "5000",
            "--wanted",
            "0",
            "--rate",
            "60",
            "-o",
            str(page),
        ],
        cwd=ROOT,
        check=True,
    )
    print(f"\npicture of the poses   {picture(result.statistics).relative_to(ROOT)}")
    print(f"picture of the plate   {learned.relative_to(ROOT)}")
    print(f"bag                    {bag.relative_to(ROOT)}")
    print(f"report                 {page.relative_to(ROOT)}")


if __name__ == "__main__":
    main()
