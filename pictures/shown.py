"""Drawing options and meters of pictures."""

from __future__ import annotations

from bpy.app.translations import pgettext_iface as iface_
from bpy.types import Scene

from ..addon.blender.text import text_width
from ..addon.view.hud import Hud
from ..addon.view.levels import LEVEL_SECONDS, levels
from ..addon.view.meter_layout import meter_hud
from ..addon.view.render_data import Options
from ..core.render.frame_result import FrameResult
from ..core.render.history import still_samples


def shown_options(scene: Scene) -> Options:
    """The scene's options without a selection, for pictures."""
    haptics = scene.haptics
    return Options(haptics.show_intra, haptics.show_best_paths, haptics.show_labels)


def meters_above(scene: Scene, result: FrameResult, size: tuple[int, int], scale: float) -> Hud:
    """The meters at the upper left of a picture."""
    shown = levels(result, still_samples(result, LEVEL_SECONDS), LEVEL_SECONDS)
    margin = 12 * scale
    items = meter_hud(
        shown,
        None,
        (0.35 * size[0], 0.5 * size[1]),
        scale,
        text_width,
        iface_("Mode {}").format(scene.haptics.mode),
    )
    high = max((top for _, _, _, top in items.bounds), default=0.0)
    return items.moved(round(margin), round(size[1] - margin - high))
