"""Valve's Steam Deck and Steam Controller."""

DEVICES = (f"{__name__}.steam",)
