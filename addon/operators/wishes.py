"""Operator that chooses the values of materials so that listeners have the desired levels."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import bpy
from bpy.types import Context, Operator

from ...core.design import wishes
from ...core.scene import spectra
from ...core.scene.coefficients import coefficients_of, transfer_coefficient
from ..blender.polling import Edit, Refused, poll_object_mode
from ..session import session, sessions
from ..view import levels

if TYPE_CHECKING:
    from ..session.sessions import Traced

_rpt = bpy.app.translations.pgettext_rpt

_ROUNDS = 4
"""Number of iterations, needed because limiters, and frequencies between band centres, make levels deviate from the predicted gains."""
_NEAR, _MISSED = 0.1, 1.0
"""Deviations [dB] up to which a wish counts as met, and beyond which it is reported as missed."""


class HAPTIC_OT_design_by_wish(Edit, Operator):
    """Choose κ of the free materials, and ρ where that is not enough, so that the listeners with a wish have the wished level"""

    bl_label = "Fulfil Wishes"

    poll = classmethod(poll_object_mode)

    def apply(self, context: Context) -> None:
        scene = context.scene
        missing: dict[str, float] = {}
        for remaining in reversed(range(_ROUNDS + 1)):
            session.trace(scene, context.evaluated_depsgraph_get(), live=True)
            traced = sessions.shown(scene)
            if traced is None or scene.haptics.mode not in ("HT", "SD"):
                raise Refused(_rpt("Materials count in modes HT and SD only"))
            shown = {level.listener: level for level in levels.shown_levels(traced, False)}
            owners = {name: bpy.data.objects[name].haptics.listener for name in shown if name in bpy.data.objects}
            missing = {name: owner.wish - shown[name].rms for name, owner in owners.items() if owner.use_wish}
            free = [item for item in scene.haptics.materials.items if item.is_free and _made_of(traced, item.name)]
            if not missing or not free:
                raise Refused(_rpt("Give a listener a wished level, and mark a material that objects are made of as free"))
            if not remaining or max(map(abs, missing.values())) < _NEAR or not _change(traced, missing, free):
                break
        self._say(missing)

    def _say(self, missing: dict[str, float]) -> None:
        """Report which wishes are not met."""
        left = [f"{name} {-rest:+.1f} dB" for name, rest in missing.items() if abs(rest) > _MISSED]
        if left:
            words = _rpt("{} of {} wishes are met; off by: {}. Free more materials, widen their bounds, or change a source")
            self.report({"WARNING"}, words.format(len(missing) - len(left), len(missing), ", ".join(left)))
        else:
            self.report({"INFO"}, _rpt("All {} wishes are met within a decibel").format(len(missing)))


def _made_of(traced: Traced, material: str) -> tuple[str, ...]:
    """The haptic objects of a frame with a material of the library."""
    return tuple(item.name for item in traced.result.graph.table.objects if item.material == material)


def _change(traced: Traced, missing: dict[str, float], free: list[Any]) -> bool:
    """Set the free materials to values with nearer levels. Returns False if none changes."""
    result = traced.result
    wished = [wishes.Wish(name, rest) for name, rest in missing.items() if math.isfinite(rest)]
    bounds = [wishes.FreeMaterial(_made_of(traced, item.name), item.least_k, max(item.least_k, item.most_k)) for item in free]
    answer = wishes.fulfil(result.graph, traced.settings, spectra.source_energies(result.sources), wished, bounds)
    changed = False
    for item, k in zip(free, answer.k, strict=True):
        if abs(transfer_coefficient(item.kappa, item.rho) - k) > 1e-4 * k:
            kappa, rho = coefficients_of(k, item.rho)
            if item.rho != rho:
                item.rho = rho
            item.kappa = kappa
            changed = True
    return changed
