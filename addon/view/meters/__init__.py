"""Meters: how much each listener feels, in the viewport and in the panel, why one feels nothing, and the four renderings compared."""
