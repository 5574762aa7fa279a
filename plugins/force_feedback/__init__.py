"""Gamepads that the Linux kernel drives."""

DRIVERS = (f"{__name__}.search",)
