"""`python -m windswept`: the command."""

import sys

from windswept._command import main

if __name__ == "__main__":
    sys.exit(main())
