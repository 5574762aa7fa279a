"""MPEG haptics: HJIF."""

from __future__ import annotations

from ...core.declaration import Choice, Number, Switch
from ...core.formats.io.catalogue import Format

FORMATS = (
    Format(
        name="hjif",
        label="MPEG haptics (HJIF)",
        suffix=".hjif",
        files="<scene>.hjif",
        carries="keyframed waves up to 860 Hz, transients, body parts",
        is_read=True,
        module=f"{__name__}.hjif",
        options={
            "profile": Choice(
                shown="Main",
                label="Profile",
                about="Main, or Simple Parametric, which more players take",
                items={"Main": ("Main", ""), "Simple Parametric": ("Simple Parametric", "")},
            ),
            "error": Number(
                shown=0.03,
                label="Error",
                about="Largest power of the error, relative to the signal's, due to an omitted "
                "keyframe",
                low=0.001,
                high=0.5,
                digits=3,
            ),
            "transients": Switch(
                shown=True,
                label="Transients",
                about="Impacts as transients, which devices may render as clicks",
            ),
        },
    ),
)
