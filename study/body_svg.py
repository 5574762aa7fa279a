"""Parts of SVG pictures of the body."""

from __future__ import annotations

from ..core.scene.body_map import HALF_WIDTH, HEIGHT, Limb

BOX = f"{-HALF_WIDTH} 0 {2 * HALF_WIDTH} {HEIGHT}"
"""What a picture of the body shows of its coordinates."""


def line(limb: Limb, attributes: str, inside: str = "") -> str:
    """A limb as an SVG element."""
    return (
        f'<line {attributes} stroke-width="{limb.width:g}" x1="{limb.start[0]:g}" '
        f'y1="{HEIGHT - limb.start[1]:g}" x2="{limb.end[0]:g}" y2="{HEIGHT - limb.end[1]:g}">'
        f"{inside}</line>"
    )
