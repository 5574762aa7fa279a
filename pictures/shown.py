"""Drawing options and meters of pictures, and their smoothing."""

from __future__ import annotations

import numpy as np
from bpy.app.translations import pgettext_iface as iface_
from bpy.types import Scene
from numpy.typing import NDArray

from ..addon.view.hud import Hud
from ..addon.view.levels import LEVEL_SECONDS, levels
from ..addon.view.meter_layout import meter_hud
from ..addon.view.render_data import Options
from ..core.render.frame_result import FrameResult
from ..core.render.history import still_samples

SMOOTHING = 2
"""Factor by which pictures are drawn larger and averaged down, for smooth edges."""


def averaged(pixels: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Box filter: the mean of every `SMOOTHING` x `SMOOTHING` pixels."""
    height, width, channels = pixels.shape
    rows, columns = height // SMOOTHING, width // SMOOTHING
    parts = pixels.reshape(rows, SMOOTHING, columns, SMOOTHING, channels)
    return np.rint(parts.mean(axis=(1, 3))).astype(np.uint8)


def shown_options(scene: Scene) -> Options:
    """The scene's options without a selection, for pictures."""
    haptics = scene.haptics
    return Options(haptics.show_intra, haptics.show_best_paths)


def meters_above(scene: Scene, result: FrameResult, size: tuple[int, int], scale: float) -> Hud:
    """The meters at the upper left of a picture."""
    shown = levels(result, still_samples(result, LEVEL_SECONDS))
    margin = 12 * scale
    items = meter_hud(
        shown,
        (0.35 * size[0], 0.5 * size[1]),
        scale,
        iface_("Mode {}").format(scene.haptics.mode),
    )
    high = max((top for _, _, _, top in items.bounds), default=0.0)
    return items.moved(round(margin), round(size[1] - margin - high))
