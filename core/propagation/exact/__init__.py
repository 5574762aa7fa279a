"""Sums over all paths with certified bounds: exact, to a tolerance, or within limits. The entry
point is `bounded_sums`."""

from .path_search import PathLimits as PathLimits
from .sums import ThresholdCosts as ThresholdCosts
from .sums import bounded_sums as bounded_sums
from .sums import path_gain as path_gain
from .sums import sum_over_paths as sum_over_paths
from .sums import threshold_costs as threshold_costs
