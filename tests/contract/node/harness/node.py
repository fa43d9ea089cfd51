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

"""The node as its user runs it: in a process of its own."""

import ctypes
import os
import signal
import subprocess
import sys
import threading

from tests.running import complaints

PATIENCE = float(os.environ.get("PATIENCE", "240"))
"""Seconds for anything that must happen; machines are slow."""

START_PATIENCE = 900.0
"""Until the node is ready: kernels may have to be compiled, by several at once."""

LIBC = ctypes.CDLL(None)
PR_SET_PDEATHSIG = 1  # of Linux's `prctl`


def parameters(**values):
    """Arguments that set parameters."""
    pairs = [("-p", f"{name}:={value}") for name, value in values.items()]
    return [argument for pair in pairs for argument in pair]


class Running:
    """A program beside the test, which goes on until it is ended."""

    def __init__(self, *command, environment=None):
        self.process = subprocess.Popen(
            list(map(str, command)),
            env={**os.environ, **(environment or {})},
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )

    def says(self, text, stream="stdout"):
        """The next line on this stream that holds `text`."""
        output = getattr(self.process, stream)
        return next(line for line in iter(output.readline, "") if text in line)

    def end(self, number=signal.SIGINT):
        """Its exit status and its complaints."""
        self.process.send_signal(number)
        _, error = self.process.communicate(timeout=PATIENCE)
        return self.process.returncode, complaints(error)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self.process.poll() is None:
            self.process.kill()
            self.process.communicate()


def _end_with_the_test():
    """Called in a process that begins: let it be killed where this one is.

    It would hold its domain and its files, and answer in place of others.
    """
    LIBC.prctl(PR_SET_PDEATHSIG, signal.SIGKILL)


class NodeProcess:
    """A node in its `folder`, with parameters by `values`, and what it says on standard
    error.
    """

    def __init__(
        self,
        log_directory,
        *arguments,
        environment=None,
        folder=None,
        program=("-m", "ros_pose_stats", "node"),
        **values,
    ):
        command = [
            sys.executable,
            *program,
            "--ros-args",
            *parameters(log_directory=log_directory, **values),
            *arguments,
        ]
        self.log_directory = log_directory
        self.lines = []
        self._news = threading.Condition()
        self.process = subprocess.Popen(
            command,
            stderr=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            text=True,
            errors="replace",
            env={**os.environ, **(environment or {})},
            cwd=folder,
            preexec_fn=_end_with_the_test,
        )
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def _read(self):
        for line in self.process.stderr:
            with self._news:
                self.lines.append(line.rstrip("\n"))
                self._news.notify_all()
        with self._news:
            self.lines.append("(end)")
            self._news.notify_all()

    @property
    def log(self):
        with self._news:
            return "\n".join(self.lines)

    def says(self, text, patience=PATIENCE):
        """Wait until a line holds `text`."""

        def said():
            return any(text in line for line in self.lines)

        with self._news:
            self._news.wait_for(lambda: said() or "(end)" in self.lines, patience)
            assert said(), f"the node never said {text!r}:\n" + "\n".join(self.lines)
        return self

    def ready(self):
        return self.says("]: ready", START_PATIENCE)

    def send(self, number):
        self.process.send_signal(number)

    def ended(self):
        """Wait for the end; the exit status."""
        try:
            self.process.wait(PATIENCE)
        except subprocess.TimeoutExpired:
            self.kill()
            raise AssertionError(f"the node did not end:\n{self.log}") from None
        self._reader.join(PATIENCE)
        self.process.stderr.close()
        return self.process.returncode

    def kill(self):
        """End it at once, if it still runs."""
        if self.process.poll() is None:
            self.process.kill()
            self.process.wait()

    def stop(self, number=signal.SIGINT):
        """End it as a user does, and look whether it ended well."""
        self.send(number)
        status = self.ended()
        assert status == 0, f"exit status {status}:\n{self.log}"
        self.assert_sound()

    def assert_sound(self):
        """Nothing in the log speaks of a fault of the program."""
        for sign in (
            "Traceback",
            "internal failure",
            "Error raised",
            "[ERROR]",
            "[FATAL]",
            "terminate called",
            "Warning:",
        ):
            assert sign not in self.log, self.log

    def __enter__(self):
        return self

    def __exit__(self, kind, error, trace):
        if error is None and self.process.poll() is None:
            self.stop()
        elif error is not None:
            self.kill()
            self._reader.join(5.0)
            print(f"log of the node:\n{self.log}")
        self.kill()
