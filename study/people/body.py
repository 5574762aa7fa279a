"""The body map as SVG: what participants click on, and where it was felt."""

from __future__ import annotations

from typing import Any, get_args

from ...core.forms import Form
from ...core.scene.body_map import View, figure
from ..body_svg import BOX, line


def body(shares: Form, *dots: Any) -> str:
    """The figure from the front, and from behind. ``shares``: how red each part is, 0 to 1;
    ``dots``: of each the view, and its place in the picture's coordinates. The page's style sheet
    colours them."""
    pictures = ""
    for view in get_args(View):
        marks = [
            line(limb, f'data-part="{limb.part}" style="--share:{shares.get(limb.part, 0):.1%}"')
            for limb in figure(view)
        ]
        marks += [
            f'<circle cx="{x:.3f}" cy="{y:.3f}" r=".015"/>' for on, x, y in dots if on == view
        ]
        pictures += f'<svg data-view="{view}" viewBox="{BOX}">{"".join(marks)}</svg>'
    return pictures
