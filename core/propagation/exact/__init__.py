"""Sums over all paths: exact, to a tolerance, or within limits."""
