"""Sums over all paths with certified bounds: exact, to a tolerance, or within limits. The entry
point is `bounded_sums`."""

from .sums import PathLimits as PathLimits
from .sums import bounded_sums as bounded_sums
