"""``python -m haptic_tracing`` is the console program ``haptic-tracing``."""

import sys

from .command_line import main

if __name__ == "__main__":  # processes that this one starts import it under another name
    sys.exit(main())
