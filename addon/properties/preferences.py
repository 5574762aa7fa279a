"""The user's preferences for all files."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any, get_type_hints

import bpy
from bpy.props import FloatVectorProperty

from ..blender.extension import ROOT
from .callbacks import view_changed
from .kinds import choice, limited, switch, text

GAIN_UNIT_ITEMS = (
    ("BOTH", "Factor and Decibel", "0.50  -6 dB"),
    ("FACTOR", "Factor", "0.50"),
    ("DECIBEL", "Decibel", "-6 dB"),
)


class PreferenceProperties:
    """Mixin: the properties of the add-on's preferences."""

    gain_unit: choice(
        "Gains", "How panels write gains", GAIN_UNIT_ITEMS, default="BOTH", update=view_changed
    )
    curve_colour: FloatVectorProperty(
        name="Curve",
        description="Colour of the gain over distance in the panel",
        subtype="COLOR_GAMMA",
        size=3,
        min=0.0,
        max=1.0,
        default=(1.0, 0.62, 0.2),
        update=view_changed,
    )
    overlay_size: limited(
        "Overlay Size",
        "How large nodes, lines and labels are in the viewport",
        1.0,
        (0.5, 3.0),
        subtype="FACTOR",
        update=view_changed,
    )
    default_device: text(
        "Default Device",
        "Part of the name of the device that Connect Device uses; empty for the first device found",
    )
    keep_awake: switch(
        "Keep Devices Awake",
        "When playback ends, hold devices at zero instead of releasing them, so that they do not "
        "fall asleep",
    )

    haptic_players: switch(
        "Haptic Players Too",
        "Look on this computer, and only here, for bHaptics Player and Intiface as well, which "
        "drive vests and other devices",
    )
    hear: switch(
        "Hear It",
        "Play what listeners feel as sound while the timeline plays and no device is connected",
        bpy.app.version >= (5, 2, 0),
    )
    was_told: switch("Hearing Was Explained", "", options={"HIDDEN"})
    show_quick_start: switch(
        "Quick Start", "Show the six steps of the quick start in the sidebar", True
    )


_DEFAULTS = SimpleNamespace(
    **{name: own.keywords["default"] for name, own in get_type_hints(PreferenceProperties).items()}
)


def preferences() -> Any:
    """The user's preferences; the defaults if the package runs without being enabled as an
    extension."""
    addon = bpy.context.preferences.addons.get(ROOT)
    return addon.preferences if addon is not None and addon.preferences is not None else _DEFAULTS


def gain_text(gain: float) -> str:
    """A gain (0 or more) in the user's number format."""
    factor = f"{gain:.2f}" if gain >= 0.1 or gain == 0 else f"{gain:.2g}"
    decibel = f"{20 * math.log10(gain):.0f} dB" if gain > 0 else "-∞ dB"
    return {"FACTOR": factor, "DECIBEL": decibel, "BOTH": f"{factor}  {decibel}"}[
        preferences().gain_unit
    ]
