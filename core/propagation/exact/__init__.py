"""Sums over all paths: exact, to a tolerance, or within limits. The entry point is `sum_over_paths`."""

from .bridge_tree_sums import PathLimits as PathLimits
from .bridge_tree_sums import PathSums as PathSums
from .sums import ThresholdCosts as ThresholdCosts
from .sums import sum_over_paths as sum_over_paths
from .sums import threshold_costs as threshold_costs
