"""Operator that fits a material and a contact to two recordings of one event."""

from __future__ import annotations

from collections.abc import Iterator
from math import exp
from pathlib import Path
from typing import TYPE_CHECKING, Any

import bpy
from bpy.types import Context, Operator, Scene

from ...core.design import recordings
from ...core.scene.coefficients import coefficients_of
from ..blender import job
from ..blender.polling import Action, poll_object_mode
from ..session import session, sessions
from ..translations.sentences import sentence

if TYPE_CHECKING:
    from ...core.graph.haptic_graph import HapticGraph

_rpt = bpy.app.translations.pgettext_rpt

_CHOOSE = "Choose two recordings, a source, a listener and an object first"


class HAPTIC_OT_fit_material(Action, Operator):
    """Set the loss of a material, and the gain of a contact, so that the scene passes vibration on as two recordings of it say"""

    bl_label = "Fit Material"
    bl_options = {"REGISTER"}

    @classmethod
    def poll(cls, context: Context) -> bool:
        chosen = context.scene.haptics.materials.fit
        if not (chosen.source_file and chosen.listener_file and chosen.source and chosen.listener and chosen.object):
            cls.poll_message_set(_CHOOSE)
            return False
        return poll_object_mode(cls, context)

    def apply(self, context: Context) -> set[str]:
        scene = context.scene
        chosen = scene.haptics.materials.fit
        session.trace(scene, context.evaluated_depsgraph_get(), live=True)
        traced = sessions.shown(scene)
        if traced is None or chosen.object is None or not chosen.object.is_editable:
            words = "Nothing traced yet" if traced is None else "The object is linked from a library; make it local or override it first"
            raise ValueError(_rpt(words))
        read = recordings.read_recordings(*(Path(bpy.path.abspath(path)) for path in (chosen.source_file, chosen.listener_file)))
        reports: list[job.Report] = []
        work = _steps(scene, traced.result.graph, read, reports)
        return job.run(self, context, job.Job("Fit Material", len(read.starts), work, lambda _: reports))


def _steps(scene: Scene, graph: HapticGraph, read: recordings.Recordings, reports: list[job.Report]) -> Iterator[None]:
    """Average the recordings window by window, then fit, as one undo step."""
    yield from read.steps()
    chosen = scene.haptics.materials.fit
    if chosen.object is None or chosen.source is None or chosen.listener is None:
        raise ValueError(_rpt(_CHOOSE))
    item = scene.haptics.materials.items.get(chosen.object.haptics.material.name)
    names = [o.name for o in graph.table.objects if item is not None and o.material == item.name] or [chosen.object.name_full]
    contact = (chosen.first.name_full, chosen.second.name_full) if chosen.is_calibrated and chosen.first and chosen.second else ()
    asked = recordings.Question(chosen.source.name_full, chosen.listener.name_full, tuple(names), contact, chosen.is_calibrated)
    found = recordings.fit(graph, read.transfer(), asked)
    owner = item or chosen.object.haptics
    kappa, rho = coefficients_of(found.k, owner.rho)
    owner.rho, owner.kappa = rho, kappa
    if contact:
        _set_gain(scene, contact, found.gain)
    chosen.fitted = item.name if item is not None else names[0]
    chosen.values = (found.damping, found.damping_error, found.gain, found.gain * (exp(found.contact_error) - 1), found.before, found.after)
    chosen.bands = found.bands.ravel()
    chosen.doubts = "\n".join(map(sentence, found.doubts))
    bpy.ops.ed.undo_push(message="Fit Material")
    words = _rpt("The model missed the recordings by {:.1f} dB, and misses them by {:.1f} dB now")
    reports.append(({"WARNING" if found.doubts else "INFO"}, words.format(found.before, found.after)))


def _set_gain(scene: Scene, contact: tuple[str, str], gain: float) -> None:
    """Set the gain of contacts of two objects in the rule for this pair, which is added if missing."""
    rules: Any = scene.haptics.transmission_table.items
    own = [r for r in rules if (r.first_kind, r.second_kind) == ("OBJECT", "OBJECT") and {r.first, r.second} == set(contact)]
    rule = own[0] if own else rules.add()
    rule.first_kind = rule.second_kind = "OBJECT"
    rule.first, rule.second = contact
    rule.function, rule.constant = "constant", gain
