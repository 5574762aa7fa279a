"""``python -m haptic_tracing`` is the console program ``haptic-tracing``."""

import sys

from .command_line import main

sys.exit(main())
