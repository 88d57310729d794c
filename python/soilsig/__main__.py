"""The command line: ``python -m soilsig``, and the program ``soilsig``."""

import sys

from . import _program

if __name__ == "__main__":
    sys.exit(_program.main())
