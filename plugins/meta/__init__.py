"""Meta Haptics Studio: ``.haptic``."""

from __future__ import annotations

from ...core.declaration import Choice, Number, Switch
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
            "actuator": Choice(
                shown="quest",
                label="Actuator",
                about="What will play the files: its range of frequencies, and its emphases",
                items={
                    "quest": ("Quest Controllers", "55 to 200 Hz"),
                    "voice_coil": ("Voice Coil", "20 to 250 Hz, as in controllers of consoles"),
                },
            ),
            "frequency_min": Number(
                shown=0.0,
                label="Lowest frequency",
                about="Hertz that the actuator plays for 0; 0: that of the chosen one",
                low=0.0,
                high=500.0,
                digits=3,
            ),
            "frequency_max": Number(
                shown=0.0,
                label="Highest frequency",
                about="Hertz that the actuator plays for 1; 0: that of the chosen one",
                low=0.0,
                high=1000.0,
                digits=3,
            ),
            "emphasis": Switch(
                shown=True, label="Emphasis", about="Impacts as emphasised breakpoints"
            ),
        },
    ),
)
