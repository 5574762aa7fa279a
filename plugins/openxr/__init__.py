"""OpenXR's ``XR_EXT_haptic_parametric``: points and transients."""

from __future__ import annotations

from ...core.declaration import Number
from ...core.formats.io.catalogue import Format

FORMATS = (
    Format(
        name="openxr",
        label="OpenXR parametric haptics",
        suffix=".parametric",
        files="<scene>.<listener>.parametric",
        carries="one keyframed oscillation, transients, for XR_EXT_haptic_parametric",
        module=f"{__name__}.parametric",
        options={
            "points": Number(
                shown=40,
                label="Points",
                about="Points a second at most, of amplitude and of frequency",
                low=5,
                high=80,
                whole=True,
            )
        },
    ),
)
