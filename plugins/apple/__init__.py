"""Apple Core Haptics: AHAP."""

from __future__ import annotations

from ...core.declaration import Number
from ...core.formats.io.catalogue import Format

FORMATS = (
    Format(
        name="ahap",
        label="Apple Core Haptics (AHAP)",
        suffix=".ahap",
        files="<scene>.<listener>.ahap .transients.ahap",
        carries="intensity and sharpness, impacts",
        is_read=True,
        module=f"{__name__}.ahap",
        options={
            "step": Number(
                shown=0.02,
                label="Step",
                about="Seconds between the points of a curve before redundant ones are removed",
                low=0.005,
                high=1.0,
                digits=3,
            ),
            "error": Number(
                shown=0.02,
                label="Error",
                about="Largest error of intensity due to an omitted point",
                low=0.0,
                high=0.5,
                digits=3,
            ),
        },
    ),
)
