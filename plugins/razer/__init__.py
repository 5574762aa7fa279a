"""Razer Sensa and WYVRN: ``.haps``."""

from __future__ import annotations

from ...core.declaration import Number, Switch
from ...core.formats.io.catalogue import Format

FORMATS = (
    Format(
        name="wyvrn",
        label="Razer Sensa / WYVRN (folder)",
        suffix=".haps",
        files="<scene>/haptic.config <scene>/Wyvrn.config <scene>/<scene>.<listener>.haps",
        carries="two keyframed oscillations, transients, five regions × two sides; read are clips "
        "of versions 5 and 6",
        is_read=True,
        module=f"{__name__}.wyvrn",
        options={
            "error": Number(
                shown=0.1,
                label="Error",
                about="Largest power of the error, relative to the signal's, due to an omitted "
                "keyframe",
                low=0.001,
                high=0.5,
                digits=3,
            ),
            "transients": Switch(shown=True, label="Transients", about="Impacts as transients"),
        },
    ),
)
