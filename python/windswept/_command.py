"""The `windswept` command."""

import os
import signal
import sys

from windswept import _native


def main() -> int:
    # The command listens for Ctrl-C itself; Python's own handler would have to wait for it to end.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    # Where `export --format usdc` looks for usd-core.
    os.environ.setdefault("WINDSWEPT_PYTHON", sys.executable)
    return _native.command(["windswept", *sys.argv[1:]])
