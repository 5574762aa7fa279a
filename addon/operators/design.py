"""Operators that choose gains and materials so that levels are the desired ones, and fit materials to recordings."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import bpy
import numpy as np
from bpy.props import FloatProperty, StringProperty
from bpy.types import Context, Operator, Scene

from ...core.design import recordings, wishes
from ...core.scene import spectra
from ...core.scene.coefficients import coefficients_of, transfer_coefficient
from ..blender import job
from ..blender.polling import LINKED, UNDO, Action, Edit, Refused, is_editable, permitted, poll_object_mode
from ..scene_reader.problem import why_untraced
from ..session import session, sessions
from ..translations.sentences import sentence
from ..view import levels

if TYPE_CHECKING:
    from ...core.graph.haptic_graph import HapticGraph

_rpt = bpy.app.translations.pgettext_rpt

_ROUNDS = 4
"""Number of iterations, needed because limiters, ceilings and frequencies between band centres make levels deviate from predictions."""
_NEAR, _MISSED = 0.1, 1.0
"""Deviations [dB] up to which a level counts as the desired one, and beyond which it is reported as missed."""
_CHOOSE = "Choose two recordings, a source, a listener and an object first"


class HAPTIC_OT_make_felt(Edit, Operator):
    """Raise the gain of this listener until it is felt, and where that is not enough the amplitude of the source it feels most"""

    bl_label = "Make It Felt"
    bl_options = {*UNDO, "INTERNAL"}

    listener: StringProperty(name="Listener", options={"HIDDEN"})
    margin: FloatProperty(name="Margin (dB)", description="How far above the threshold of feeling", default=6.0, min=0.0, max=60.0)

    def apply(self, context: Context) -> None:
        found: Any = context.scene.objects.get(self.listener)
        margin = -math.inf
        for _ in range(_ROUNDS):
            session.trace(context.scene, context.evaluated_depsgraph_get(), live=True)
            traced = sessions.shown(context.scene)
            names = [] if traced is None else [item.name for item in traced.result.listeners]
            if traced is None:
                raise Refused(why_untraced(session.problems_of(context.scene)))
            if found is None or not is_editable(found) or self.listener not in names:
                raise Refused(_rpt("'{}' can't be changed: it is linked from a library, or no listener any more").format(self.listener))
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


def _raise(listener: Any, traced: sessions.Traced, index: int, missing: float) -> bool:
    """Raise the gain of a listener, and that of its strongest source when the gain is at its maximum, by ``missing`` decibels in total.
    Returns False if neither can be raised further."""
    if not math.isfinite(missing):
        return False
    factor, result = 10 ** (missing / 20), traced.result
    owners = [(listener, "gain")]
    strongest = bpy.data.objects.get(result.sources[int(np.argmax(result.amplitudes[:, index]))].name)
    if strongest is not None and is_editable(strongest) and strongest.haptics.source.enabled:
        owners.append((strongest.haptics.source, "amplitude"))
    is_raised = False
    for owner, name in owners:
        before, most = getattr(owner, name), owner.bl_rna.properties[name].hard_max
        if before > 0 and factor > 1 and before < most:
            setattr(owner, name, min(before * factor, most))
            factor /= getattr(owner, name) / before
            is_raised = True
    return is_raised


class HAPTIC_OT_design_by_wish(Edit, Operator):
    """Choose κ of the free materials, and ρ where that is not enough, so that the listeners with a wish have the wished level"""

    bl_label = "Fulfil Wishes"

    def apply(self, context: Context) -> None:
        scene = context.scene
        missing: dict[str, float] = {}
        for remaining in reversed(range(_ROUNDS + 1)):
            session.trace(scene, context.evaluated_depsgraph_get(), live=True)
            traced = sessions.shown(scene)
            if traced is None:
                raise Refused(why_untraced(session.problems_of(scene)))
            if scene.haptics.mode not in ("HT", "SD"):
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


def _made_of(traced: sessions.Traced, material: str) -> tuple[str, ...]:
    """The haptic objects of a frame with a material of the library."""
    return tuple(item.name for item in traced.result.graph.table.objects if item.material == material)


def _change(traced: sessions.Traced, missing: dict[str, float], free: list[Any]) -> bool:
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


class HAPTIC_OT_fit_material(Action, Operator):
    """Set the loss of a material, and the gain of a contact, so that the scene transmits vibration as two recordings show"""

    bl_label = "Fit Material"
    bl_options = {"REGISTER"}

    @classmethod
    def poll(cls, context: Context) -> bool:
        chosen = context.scene.haptics.materials.fit
        is_chosen = bool(chosen.source_file and chosen.listener_file and chosen.source and chosen.listener and chosen.object)
        return permitted(cls, is_chosen, _CHOOSE) and poll_object_mode(cls, context)

    def apply(self, context: Context) -> set[str]:
        scene = context.scene
        chosen = scene.haptics.materials.fit
        session.trace(scene, context.evaluated_depsgraph_get(), live=True)
        traced = sessions.shown(scene)
        if traced is None or chosen.object is None or not is_editable(chosen.object):
            raise ValueError(_rpt("Nothing traced yet" if traced is None else LINKED))
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
    error = found.gain * (math.exp(found.contact_error) - 1)
    chosen.values = (found.damping, found.damping_error, found.gain, error, found.before, found.after)
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
