"""Benchmarks of the product; ``python -m benchmarks`` runs all of them."""

import sys
from pathlib import Path

sys.path.append(str(Path(__file__).resolve().parents[1] / "tests" / "references"))

import own_temporary_folder

own_temporary_folder.make()
