"""bHaptics' vests, arms, hands and feet: ``.tact``."""

from __future__ import annotations

from ...core.declaration import Number
from ...core.formats.io.catalogue import Format

FORMATS = (
    Format(
        name="tact",
        label="bHaptics (.tact)",
        suffix=".tact",
        files="<scene>.<device>.tact",
        carries="amplitude of each bHaptics motor every 20 ms",
        is_read=True,
        module=f"{__name__}.tact",
        options={
            "levels": Number(
                shown=50,
                label="Levels",
                about="Steps of strength: fewer make smaller files",
                low=2,
                high=100,
                whole=True,
            )
        },
    ),
)
