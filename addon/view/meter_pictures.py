"""The scope and the body map as pictures in the panel, as the meters in the viewport have them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from ...core.scene.body_map import HALF_WIDTH, HEIGHT
from .levels import Level
from .meter_layout import Scope, add_body, add_scope, colour_of
from .panel_picture import SIZE, Canvas, Picture, Pixels

_scope = Picture()
_body = Picture()


def scope_icon(scope: Scope) -> int:
    """The identifier of the icon with the scope."""
    key = scope.samples.tobytes(), scope.sample_rate
    return _scope.icon(key, lambda: scope_picture(scope))


def body_icon(levels: Sequence[Level]) -> int:
    """The identifier of the icon with the body."""
    parts = {level.body_part: level for level in levels if level.body_part}
    key = tuple((name, colour_of(level)) for name, level in parts.items())
    return _body.icon(key, lambda: body_picture(parts))


def scope_picture(scope: Scope) -> Pixels:
    """The last second, as wide and high as the picture."""
    builder = Canvas()
    add_scope(builder, (0.0, 0.0), (SIZE, SIZE), scope)
    return builder.painted()


def body_picture(parts: Mapping[str, Level]) -> Pixels:
    """Both figures, side by side over the width of the picture."""
    builder = Canvas()
    height = SIZE * HEIGHT / (4 * HALF_WIDTH)
    add_body(builder, (0.0, (SIZE - height) / 2), height, parts, ())
    return builder.painted()
