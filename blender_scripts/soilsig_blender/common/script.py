"""How a script runs inside Blender: its arguments, and how it reports a failure."""

import sys
import traceback

from .errors import BedError
from .events import emit

FAILED = 13


def run(main):
    """Runs `main` with the arguments after `--`; ends the process with a status if it fails."""
    arguments = sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else []
    status = 0
    try:
        _require_numpy()
        main(arguments)
    except BedError as error:
        emit("error", kind=error.kind, message=str(error), hint=error.hint)
        status = FAILED
    except Exception as error:  # whatever it is, the caller is told
        traceback.print_exc()
        emit("error", kind="internal", message=f"{type(error).__name__}: {error}", hint=None)
        status = FAILED
    sys.stdout.flush()
    if status:
        sys.exit(status)


def _require_numpy():
    try:
        import numpy  # noqa: F401
    except ImportError as error:
        raise BedError(
            "numpy",
            f"the Python inside Blender ({sys.prefix}) cannot import numpy: {error}",
            "apt install python3-numpy",
        ) from error
