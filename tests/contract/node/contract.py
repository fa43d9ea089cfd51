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

"""Names, types and defaults that feeder planners are written against."""

PACKAGE = "ros_pose_stats_msgs"

SERVICES = {
    "estimate": f"{PACKAGE}/srv/EstimatePoses",
    "get_statistics": f"{PACKAGE}/srv/GetStatistics",
    "fit_plate": f"{PACKAGE}/srv/FitPlate",
    "forget_part": f"{PACKAGE}/srv/ForgetPart",
    "start_drop_simulation": f"{PACKAGE}/srv/StartDropSimulation",
    "get_drop_simulation": f"{PACKAGE}/srv/GetDropSimulation",
    "list_drop_simulations": f"{PACKAGE}/srv/ListDropSimulations",
    "cancel_drop_simulation": f"{PACKAGE}/srv/CancelDropSimulation",
}
SUBSCRIPTIONS = {
    "/pose_stats/part_mesh": f"{PACKAGE}/msg/PartMesh",
    "/pose_stats/pose_counts": f"{PACKAGE}/msg/PoseCounts",
    "/pose_stats/observed_parts": f"{PACKAGE}/msg/ObservedParts",
}
PUBLICATIONS = {
    "/pose_stats/pose_statistics": f"{PACKAGE}/msg/PoseStatistics",
    "/pose_stats/parts": f"{PACKAGE}/msg/PartList",
    "/pose_stats/markers": "visualization_msgs/msg/MarkerArray",
    "/diagnostics": "diagnostic_msgs/msg/DiagnosticArray",
}
ACTION = {
    "/pose_stats/simulate_drops": f"{PACKAGE}/action/SimulateDrops",
    "/pose_stats/plan_feeding": f"{PACKAGE}/action/PlanFeeding",
    "/pose_stats/simulate_flips": f"{PACKAGE}/action/SimulateFlips",
}

DEFAULTS = {
    "mesh_topics": [],
    "mesh_unit": 1.0,
    "mesh_folders": [],
    "plate_frame": "plate",
    "plate": "",
    "plates": "",
    "default_method": "auto",
    "restitution": 0.5,
    "drop_height": -1.0,
    "refine_drops": 0,
    "drops": 10_000,
    "target_error": 0.0,
    "workers": 0,
    "keep_cores": 1,
    "max_queued_jobs": 16,
    "max_drops": 10_000_000,
    "max_job_seconds": 600.0,
    "max_parts": 256,
    "max_mesh_bytes": 67_108_864,
    "max_part_bytes": 2**30,
    "cluster_tolerance": 0.0025,
    "round_sides": 192,
    "flip_height": 0.0,
    "log_directory": "",
    "max_bag_bytes": 536_870_912,
    "max_log_bytes": 2**33,
    "log_drops": False,
    "restore": True,
    "state_file": "",
}

FIXED = {
    "mesh_folders",
    "mesh_topics",
    "log_directory",
    "max_bag_bytes",
    "max_log_bytes",
    "restore",
    "state_file",
}
"""What can be set at the start only."""

CODES = {
    "OK": 0,
    "UNKNOWN_PART": 1,
    "BAD_VALUE": 2,
    "BAD_MESH": 3,
    "BUSY": 4,
    "TIMED_OUT": 5,
    "NOT_RECORDED": 6,
    "NOT_FOUND": 7,
    "INTERNAL": 8,
    "CANCELLED": 9,
}
STATES = {
    "UNKNOWN": 0,
    "QUEUED": 1,
    "RUNNING": 2,
    "DONE": 3,
    "CANCELLED": 4,
    "FAILED": 5,
}
