"""The body map as SVG: what participants click on, and where it was felt."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from types import MappingProxyType

from ...core.scene.body_map import HALF_WIDTH, HEIGHT, Limb, View, figure

BOX = f"{-HALF_WIDTH} 0 {2 * HALF_WIDTH} {HEIGHT}"
"""What a picture of the body shows of its coordinates."""


def line(limb: Limb, attributes: str, inside: str = "") -> str:
    """A limb as an SVG element."""
    return (
        f'<line {attributes} stroke-width="{limb.width:g}" x1="{limb.start[0]:g}" '
        f'y1="{HEIGHT - limb.start[1]:g}" x2="{limb.end[0]:g}" y2="{HEIGHT - limb.end[1]:g}">'
        f"{inside}</line>"
    )


def svg(
    view: View,
    shares: Mapping[str, float] = MappingProxyType({}),
    dots: Iterable[tuple[float, float]] = (),
) -> str:
    """The figure from the front or from behind. ``shares``: how red each part is, 0 to 1; ``dots``:
    places in the picture's coordinates. The page's style sheet colours them."""
    marks = [
        line(
            limb,
            f'class="limb" data-part="{limb.part}" style="--share:{shares.get(limb.part, 0):.1%}"',
        )
        for limb in figure(view)
    ]
    marks += [f'<circle cx="{x:.3f}" cy="{y:.3f}" r=".015"/>' for x, y in dots]
    return f'<svg data-view="{view}" viewBox="{BOX}">{"".join(marks)}</svg>'
