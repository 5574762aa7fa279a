"""Android's ``VibrationEffect.createWaveform``: durations and amplitudes."""

from __future__ import annotations

from ...core.declaration import Number
from ...core.formats.io.catalogue import Format

FORMATS = (
    Format(
        name="android",
        label="Android waveform",
        suffix=".waveform",
        files="<scene>.<listener>.waveform",
        carries="amplitude every 10 ms, for Android's createWaveform",
        module=f"{__name__}.waveform",
        options={
            "milliseconds": Number(
                shown=10,
                label="Milliseconds",
                about="How long an amplitude lasts at least",
                low=5,
                high=100,
                whole=True,
            )
        },
    ),
)
