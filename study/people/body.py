"""The body map as SVG: what participants click on, and where it was felt."""

from __future__ import annotations

from collections.abc import Iterable

from ...core.forms import Form
from ...core.scene.body_map import View, figure
from ..body_svg import BOX, line


def svg(view: View, shares: Form, dots: Iterable[tuple[float, float]] = ()) -> str:
    """The figure from the front or from behind. ``shares``: how red each part is, 0 to 1; ``dots``:
    places in the picture's coordinates. The page's style sheet colours them."""
    marks = [
        line(limb, f'data-part="{limb.part}" style="--share:{shares.get(limb.part, 0):.1%}"')
        for limb in figure(view)
    ]
    marks += [f'<circle cx="{x:.3f}" cy="{y:.3f}" r=".015"/>' for x, y in dots]
    return f'<svg data-view="{view}" viewBox="{BOX}">{"".join(marks)}</svg>'
