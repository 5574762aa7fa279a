"""Gamepads of 8BitDo, Amazon and NVIDIA, and those that speak SInput."""

DEVICES = (f"{__name__}.pads",)
