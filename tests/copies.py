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

"""Programs that speak ROS, each in a process of its own that starts at once.

Where a participant of DDS is taken down, Fast DDS 2.14 now and then waits for ever with
the interpreter locked, and no time limit of pytest is heard any more. So no worker runs
such programs itself: one process beside it has loaded all that they need, and each is
run in a copy (a fork) of that.
"""

import atexit
import contextlib
import json
import os
import select
import signal
import subprocess
import sys
import traceback
from functools import cache
from importlib import import_module
from pathlib import Path
from tempfile import TemporaryFile

ROOT = Path(__file__).resolve().parents[1]
LONGEST_SECONDS = 240
FAILED = 70


class Copies:
    """The process that is copied; it ends with the one that asks."""

    def __init__(self):
        self._process = subprocess.Popen(
            [sys.executable, "-m", __name__],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            cwd=ROOT,
            env={**os.environ, "OPENBLAS_NUM_THREADS": "1"},
            start_new_session=True,
        )

    def run(self, program, words):
        """Status, standard output and standard error of a program, as
        `module:function`.

        It has the environment and the folder of the caller.
        """
        request = {
            "program": program,
            "words": words,
            "environment": dict(os.environ),
            "folder": str(Path.cwd()),
        }
        try:
            self._process.stdin.write(json.dumps(request).encode() + b"\n")
            self._process.stdin.flush()
            return json.loads(self._process.stdout.readline())
        except BaseException:
            self.end()  # else the next one would be answered for this one
            raise

    def end(self):
        """End it, and with it a copy that still runs."""
        copies.cache_clear()
        with contextlib.suppress(ProcessLookupError):
            os.killpg(self._process.pid, signal.SIGKILL)
        self._process.communicate()


@cache
def copies():
    """The process that is copied, started where it is needed first."""
    process = Copies()
    atexit.register(process.end)
    return process


def main():
    """Answer requests until there are no more."""
    requests = os.fdopen(os.dup(0), "rb")
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
    os.dup2(2, 1)
    for module in ("tools.cli", "node.node", "node.client"):
        import_module(f"ros_pose_stats.{module}")
    for request in requests:
        answer = run_copy(**json.loads(request))
        answers.write(json.dumps(answer).encode() + b"\n")
        answers.flush()


def run_copy(program, words, environment, folder):
    """What `Copies.run` returns."""
    with TemporaryFile() as output, TemporaryFile() as error:
        process = os.fork()
        if process == 0:
            os.environ.clear()
            os.environ.update(environment)
            os.chdir(folder)
            os.dup2(output.fileno(), 1)
            os.dup2(error.fileno(), 2)
            become(program, words)
        with os.fdopen(os.pidfd_open(process)) as end:
            if not select.select([end], [], [], LONGEST_SECONDS)[0]:
                os.kill(process, signal.SIGKILL)
        status = os.waitstatus_to_exitcode(os.waitpid(process, 0)[1])
        return status, *(written(stream) for stream in (output, error))


def become(program, words):
    """Run a program as its executable does; never returns."""
    status = FAILED
    try:
        module, _, function = program.partition(":")
        sys.argv = [module, *words]
        status = getattr(import_module(module), function)()
    except SystemExit as end:  # of the parser
        status = end.code
    except BaseException:
        traceback.print_exc()
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(status or 0)


def written(stream):
    stream.seek(0)
    return stream.read().decode(errors="replace")


if __name__ == "__main__":
    main()
