"""The `windswept` command."""

import signal
import sys

from windswept import _native


def main() -> int:
    # The command listens for Ctrl-C itself; Python's own handler would have to wait for it to end.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    return _native.command(["windswept", *sys.argv[1:]])
