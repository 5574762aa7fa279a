"""Meta Haptics Studio: ``.haptic``."""

from __future__ import annotations

from ...core.declaration import Number, Switch
from ...core.formats.io.catalogue import Format

FORMATS = (
    Format(
        name="haptic",
        label="Meta Haptics (.haptic)",
        suffix=".haptic",
        files="<scene>.<listener>.haptic .acf",
        carries="one keyframed oscillation, emphasis",
        is_read=True,
        module=f"{__name__}.haptic",
        options={
            "points": Number(
                shown=40,
                label="Points",
                about="Breakpoints a second at most; 0: as many as the wave needs",
                low=0,
                high=80,
                whole=True,
            ),
            "error": Number(
                shown=0.05,
                label="Error",
                about="With 0 points: power of the error relative to the signal's",
                low=0.001,
                high=0.5,
                digits=3,
            ),
            "frequency_min": Number(
                shown=55.0,
                label="Lowest frequency",
                about="Hertz that the actuator plays for 0; 55 is that of Quest controllers",
                low=1.0,
                high=500.0,
                digits=3,
            ),
            "frequency_max": Number(
                shown=200.0,
                label="Highest frequency",
                about="Hertz that the actuator plays for 1; 200 is that of Quest controllers",
                low=2.0,
                high=1000.0,
                digits=3,
            ),
            "emphasis": Switch(
                shown=True, label="Emphasis", about="Impacts as emphasised breakpoints"
            ),
        },
    ),
)
