"""Haptic players on this computer: bHaptics Player and Intiface."""

PLAYERS = (f"{__name__}.network",)
