"""`python -m windswept`: the command."""

import sys

from windswept._command import main

sys.exit(main())
