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

"""The notice at the top of every source file, as `ament_copyright` of Jazzy reads it.

`python -m tests.house.notices` writes it into the files that lack it.
"""

import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
NOTICE = """\
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
"""
LICENSED = "*.py"


def source_files() -> list[Path]:
    """The files of the repository that are to have it; empty ones need none."""
    command = ["git", "ls-files", "-z", LICENSED]
    listed = subprocess.run(command, cwd=ROOT, capture_output=True, check=True)
    names = filter(None, listed.stdout.decode().split("\0"))
    files = [ROOT / name for name in names]
    return [file for file in files if file.is_file() and file.stat().st_size]


def files_without_notice() -> list[Path]:
    """Source files that do not begin with the notice."""
    return [
        file
        for file in source_files()
        if not file.read_text(encoding="utf-8").startswith(NOTICE)
    ]


def main() -> None:
    """Write the notice into the files that lack it."""
    for file in files_without_notice():
        content = file.read_text(encoding="utf-8")
        file.write_text(f"{NOTICE}\n{content}", encoding="utf-8")
        print(file.relative_to(ROOT))


if __name__ == "__main__":
    main()
