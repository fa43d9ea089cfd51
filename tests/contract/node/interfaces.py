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

"""Every field of every interface with its type: what planners are written against.

A change here is one of the contract. Types as in the files of `msg_defs`.
"""

INTERFACES = {
    "action/PlanFeeding.Goal": (
        "string part_id, uint32[] wanted, float64 dropped_per_minute, "
        "float64 kick_height, float64 cycle_seconds, float64 plate_length, "
        "float64 plate_width, float64 clearance, float64 look_seconds, "
        "float64 pick_seconds, float64 drop_seconds, float64[] kick_heights, "
        "string feeder_setting"
    ),
    "action/PlanFeeding.Result": (
        "bool success, uint16 code, string message, Note[] warnings, float64 accepted, "
        "float64 accepted_low, float64 accepted_high, float64 passes, "
        "float64 passes_low, float64 passes_high, float64 flips, "
        "float64 flips_low, float64 flips_high, float64 accepted_per_minute, "
        "float64 accepted_per_minute_low, float64 accepted_per_minute_high, "
        "float64[] transition, float64 kick_height, uint8[] action, "
        "uint32 parts_on_plate, float64 pickable, uint32 kicks, "
        "float64 parts_per_minute, float64 parts_per_minute_low, "
        "float64 parts_per_minute_high"
    ),
    "action/PlanFeeding.Feedback": (
        "uint32 kick_heights_done, uint32 kick_heights_total, uint64 flips_done, "
        "uint64 flips_total"
    ),
    "action/SimulateDrops.Goal": (
        "string part_id, PartMesh part, uint64 drops, float64 restitution, "
        "float64 drop_height, uint64 seed, float64 target_error, "
        "float64 max_seconds"
    ),
    "action/SimulateDrops.Result": (
        "bool success, uint16 code, string message, string job_id, "
        "PoseStatistics statistics"
    ),
    "action/SimulateDrops.Feedback": (
        "string job_id, uint64 drops_done, uint64 drops_total, "
        "float64 expected_error, float64 drops_per_second"
    ),
    "action/SimulateFlips.Goal": (
        "string part_id, float64 kick_height, uint64 drops, uint64 seed"
    ),
    "action/SimulateFlips.Result": (
        "bool success, uint16 code, string message, Note[] warnings, string part_id, "
        "string part_digest, float64 restitution, float64 kick_height, "
        "uint64 seed, uint64[] flips, uint64[] unsettled, float64[] transition, "
        "float64[] standard_error"
    ),
    "action/SimulateFlips.Feedback": "uint64 flips_done, uint64 flips_total",
    "msg/DropRecords": (
        "std_msgs/Header header, string job_id, string part_digest, "
        "uint64 first_drop, float32[] start_down, int32[] pose_index, "
        "uint32[] impacts, float32[] seconds, float32[] energy_left, "
        "bool stopped_at_trap, bool[] drawn"
    ),
    "msg/JobEvent": (
        "std_msgs/Header header, JobStatus status, bool part_forgotten, "
        "string part_digest, bool refinement, float64 restitution, "
        "float64 drop_height, float64 cluster_tolerance, uint32 round_sides, "
        "uint64 seed, float64 target_error, float64 max_seconds, string message"
    ),
    "msg/JobStatus": (
        "string job_id, string part_id, uint8 state, uint16 code, "
        "uint64 drops_done, uint64 drops_total"
    ),
    "msg/Note": "string code, string text, bool acts",
    "msg/ObservedParts": (
        "std_msgs/Header header, string part_id, uint64 numbering, "
        "geometry_msgs/Pose[] poses, float64[] confidence, int32 from_pose, "
        "string feeder_setting"
    ),
    "msg/PartList": "std_msgs/Header header, PartState[] parts",
    "msg/PartMesh": (
        "std_msgs/Header header, string part_id, shape_msgs/Mesh mesh, "
        "float64[] vertices, uint32[] triangles, float64 unit, "
        "geometry_msgs/Inertia inertia, float64 restitution, "
        "float64 drop_height, string mesh_resource, string mesh_resource_unit, "
        "int32 body"
    ),
    "msg/PartState": (
        "string part_id, string part_digest, uint64 revision, string method, "
        "float64 expected_error, bool final"
    ),
    "msg/PoseCounts": (
        "std_msgs/Header header, string part_id, uint64 numbering, string plate, "
        "float64 drop_height, uint32[] index, uint64[] count, "
        "uint64 unclassified, int32 from_pose, string feeder_setting"
    ),
    "msg/PoseOutline": (
        "string pose_id, float64 height, uint32[] corners, float64[] points"
    ),
    "msg/PoseStatistics": (
        "std_msgs/Header header, string part_id, string part_digest, "
        "float64 radius, uint32 bodies, float64 unit, bool unit_guessed, "
        "string method, float64 restitution, float64 drop_height, string scene, "
        "float64 cluster_tolerance, uint32 round_sides, uint64 numbering, "
        "uint64 drops, uint64 unsettled, uint64 counted_parts, "
        "float64 model_gap, uint64 seed, float64 expected_error, "
        "float64 largest_error, float64 plate_error, string plate, "
        "builtin_interfaces/Duration compute_time, string job_id, "
        "uint64 revision, bool final, string version, StablePose[] poses, "
        "Note[] warnings"
    ),
    "msg/StablePose": (
        "uint32 index, string pose_id, uint32 group, uint32 group_size, "
        "geometry_msgs/Pose pose, geometry_msgs/Vector3 down, float64 height, "
        "float64 top, float64 margin, float64 barrier, float64 spread, "
        "bool rolls, geometry_msgs/Vector3 roll_axis, uint32 yaw_symmetry, "
        "float64 probability, float64 probability_low, float64 probability_high, "
        "float64 standard_error, float64 group_probability, uint64 count, "
        "uint32[] alike_from_above, float64[] support_polygon, float64[] outline"
    ),
    "srv/CancelDropSimulation.Request": "string job_id",
    "srv/CancelDropSimulation.Response": ("bool success, uint16 code, string message"),
    "srv/EstimatePoses.Request": (
        "string part_id, PartMesh part, string method, float64 restitution, "
        "float64 drop_height, float64 target_error, "
        "geometry_msgs/Vector3 com_offset"
    ),
    "srv/EstimatePoses.Response": (
        "bool success, uint16 code, string message, PoseStatistics statistics"
    ),
    "srv/FitPlate.Request": "string plate, bool apply",
    "srv/FitPlate.Response": (
        "bool success, uint16 code, string message, float64 restitution, "
        "float64 restitution_low, float64 restitution_high, float64 drop_height, "
        "float64 drop_height_low, float64 drop_height_high, uint32 round_sides, "
        "uint32 round_sides_low, uint32 round_sides_high, float64 plate_error, "
        "float64 p_value, uint64 counted, string[] parts"
    ),
    "srv/ForgetPart.Request": "string part_id",
    "srv/ForgetPart.Response": "bool success, uint16 code, string message",
    "srv/GetDropSimulation.Request": "string job_id",
    "srv/GetDropSimulation.Response": (
        "bool success, uint16 code, string message, JobStatus status, "
        "PoseStatistics statistics"
    ),
    "srv/GetStatistics.Request": "string part_id, float64[] heights",
    "srv/GetStatistics.Response": (
        "bool success, uint16 code, string message, PoseStatistics[] statistics, "
        "PoseOutline[] outlines"
    ),
    "srv/ListDropSimulations.Request": "",
    "srv/ListDropSimulations.Response": (
        "bool success, uint16 code, string message, JobStatus[] jobs"
    ),
    "srv/StartDropSimulation.Request": (
        "string part_id, PartMesh part, uint64 drops, float64 restitution, "
        "float64 drop_height, uint64 seed, float64 target_error, "
        "float64 max_seconds"
    ),
    "srv/StartDropSimulation.Response": (
        "bool success, uint16 code, string message, string job_id"
    ),
}
