"""Operator that raises the gain of a listener until its level is felt."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import bpy
import numpy as np
from bpy.props import FloatProperty, StringProperty
from bpy.types import Context, Operator

from ..blender.polling import UNDO, Edit, Refused, poll_object_mode
from ..session import session, sessions
from ..view import levels

if TYPE_CHECKING:
    from ..session.sessions import Traced

_rpt = bpy.app.translations.pgettext_rpt

_ROUNDS = 4
"""Number of iterations, needed because a limiter or a ceiling makes the level rise less than the gain."""
_NEAR = 0.1
"""Tolerance of the margin [dB]."""


class HAPTIC_OT_make_felt(Edit, Operator):
    """Raise the gain of this listener until it is felt, and where that is not enough the amplitude of the source it feels most"""

    bl_label = "Make It Felt"
    bl_options = {*UNDO, "INTERNAL"}

    listener: StringProperty(name="Listener", options={"HIDDEN"})
    margin: FloatProperty(name="Margin (dB)", description="How far above the threshold of feeling", default=6.0, min=0.0, max=60.0)

    poll = classmethod(poll_object_mode)

    def apply(self, context: Context) -> None:
        found: Any = context.scene.objects.get(self.listener)
        margin = -math.inf
        for _ in range(_ROUNDS):
            session.trace(context.scene, context.evaluated_depsgraph_get(), live=True)
            traced = sessions.shown(context.scene)
            names = [] if traced is None else [item.name for item in traced.result.listeners]
            if traced is None or found is None or not found.is_editable or self.listener not in names:
                raise Refused(_rpt("{} can't be changed").format(self.listener))
            index = names.index(self.listener)
            margin = levels.shown_levels(traced, False)[index].margin
            if margin >= self.margin - _NEAR or not _raise(found.haptics.listener, traced, index, self.margin - margin):
                break
        if margin == -math.inf:
            raise Refused(_rpt("Nothing reaches '{}'; the reason is in Why Is It Silent?").format(self.listener))
        if margin < self.margin - _NEAR:
            words = _rpt("'{}' has a margin of {:.0f} dB now; more needs other materials, a nearer source or another frequency")
            self.report({"WARNING"}, words.format(self.listener, margin))
        else:
            self.report({"INFO"}, _rpt("'{}' is felt with a margin of {:.0f} dB").format(self.listener, margin))


def _raise(listener: Any, traced: Traced, index: int, missing: float) -> bool:
    """Raise the gain of a listener, and that of its strongest source when the gain is at its maximum, by ``missing`` decibels in total.
    Returns False if neither can be raised further."""
    if not math.isfinite(missing):
        return False
    factor, result = 10 ** (missing / 20), traced.result
    owners = [(listener, "gain")]
    strongest = bpy.data.objects.get(result.sources[int(np.argmax(result.gains[:, index]))].name)
    if strongest is not None and strongest.is_editable and strongest.haptics.source.enabled:
        owners.append((strongest.haptics.source, "amplitude"))
    is_raised = False
    for owner, name in owners:
        before, most = getattr(owner, name), owner.bl_rna.properties[name].hard_max
        if before > 0 and factor > 1 and before < most:
            setattr(owner, name, min(before * factor, most))
            factor /= getattr(owner, name) / before
            is_raised = True
    return is_raised
