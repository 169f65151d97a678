"""windswept in processes of their own, so that Blender stays alive and no graphics driver is in it twice."""

import os
import re
import subprocess
import sys
import time
from pathlib import Path

import bpy

#: The job under way, of which there is one at a time.
running = None


class Job:
    """Commands that run one after the other, and what they said so far.

    Args:
        commands: arguments of the Python that Blender runs.
        folder: where what they say is kept, in log.txt.
    """

    def __init__(self, commands, folder):
        self.commands = list(commands)
        self.log = Path(folder) / "log.txt"
        self.log.write_bytes(b"")
        self.child = None
        self.failed = False

    def goes_on(self):
        """Whether there is something to wait for; begins the next command where one has ended."""
        if self.child is not None and self.child.poll() is None:
            return True
        self.failed = self.child is not None and self.child.returncode != 0
        if self.failed or not self.commands:
            return False
        with open(self.log, "ab") as log:
            self.child = subprocess.Popen(
                [sys.executable, *self.commands.pop(0)],
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=subprocess.STDOUT,
                env=environment(),
                # No console window on Windows.
                creationflags=getattr(subprocess, "CREATE_NO_WINDOW", 0),
            )
        return True

    def wait(self):
        while self.goes_on():
            time.sleep(0.02)

    def stop(self):
        self.commands.clear()
        if self.child is not None and self.child.poll() is None:
            self.child.terminate()
            try:
                self.child.wait(timeout=10)
            except subprocess.TimeoutExpired:
                self.child.kill()
                self.child.wait()

    def lines(self):
        return self.log.read_text(encoding="utf-8", errors="replace").splitlines()

    def progress(self):
        """Part of the steps that are done, and the last line."""
        lines = self.lines()
        counts = [found for line in lines if (found := re.match(r"(\d+) of (\d+) steps", line))]
        part = int(counts[-1][1]) / int(counts[-1][2]) if counts else 0.0
        return part, lines[-1] if lines else ""

    def warnings(self):
        return [line for line in self.lines() if line.startswith("warning: ")]

    def error(self):
        """Why it failed."""
        lines = self.lines()
        first = next((k for k, line in enumerate(lines) if line.startswith("error: ")), max(len(lines) - 3, 0))
        return "\n".join(lines[first:]) or f"ended with status {self.child.returncode}"


def environment():
    """That of a child whose Python finds the wheel, and USD's library, which is Blender's own."""
    import windswept

    wheel = Path(windswept.__file__).parents[1]
    python = Path(bpy.utils.system_resource("PYTHON"))
    own = ["lib/site-packages"] if os.name == "nt" else [f"lib/python{sys.version_info[0]}.{sys.version_info[1]}/site-packages"]
    paths = [wheel, *(python / folder for folder in own), *filter(None, [os.environ.get("PYTHONPATH")])]
    return {**os.environ, "PYTHONPATH": os.pathsep.join(map(str, paths)), "WINDSWEPT_PYTHON": sys.executable}


def stop():
    """Ends the job under way, if there is one."""
    global running
    if running is not None:
        running.stop()
        running = None
