"""The parts that tests of the server share, found by their folders."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
