"""A web page that plays by itself."""

from __future__ import annotations

from ...core.formats.io.catalogue import Format

FORMATS = (
    Format(
        name="web",
        label="Web page that plays by itself (HTML)",
        suffix=".html",
        files="<scene>.html",
        carries="a self-contained page: body map, waveforms up to 900 Hz, sound, gamepad",
        module=f"{__name__}.web",
    ),
)
