"""Operators that choose gains and materials so that levels are the desired ones, and fit materials
to recordings."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import bpy
from bpy.types import Context, Event, Scene, UILayout

from ...core.design import felt, recordings, wishes
from ...core.scene import spectra
from ...core.scene.coefficients import coefficients_of, transfer_coefficient
from ..blender import job
from ..blender.compatibility import is_animated
from ..blender.polling import (
    LINKED,
    OBJECT_MODE,
    Action,
    Edit,
    Need,
    Refused,
    is_editable,
)
from ..blender.words import TranslatedError, report_text, show_pair, ui_text
from ..properties.kinds import limited, switch, text
from ..scene_reader.problem import why_untraced
from ..session import session, sessions
from ..translations.sentences import sentence
from ..view import levels

if TYPE_CHECKING:
    from ...core.graph.haptic_graph import HapticGraph

_ROUNDS = 4
"""Number of iterations, needed because limiters, ceilings and frequencies between band centres make
levels deviate from predictions."""
_NEAR, _MISSED = 0.1, 1.0
"""Deviations [dB] up to which a level counts as the desired one, and beyond which it is reported as
missed."""
_CHOOSE = "Choose two recordings, a source, a listener and an object first"


class HAPTIC_OT_make_felt(Edit):
    """Raise what the selected listeners feel above the threshold of feeling, by as few changes as possible, which are shown first"""

    bl_label = "Make It Felt"

    listener: text("Listener", "", options={"HIDDEN", "SKIP_SAVE"})
    margin: limited("Margin (dB)", "How far above the threshold of feeling", 6.0, (0.0, 60.0))
    use_amplitude: switch(
        "Amplitude",
        "If the gain of the listener is not enough, raise the amplitude of the source that it "
        "feels most",
        True,
    )
    use_frequency: switch(
        "Frequency",
        "If that is not enough, change the frequency of that source to one that is felt better",
        True,
    )
    use_material: switch(
        "Materials",
        "If that is not enough, change the materials on the path to those that pass on more",
        True,
    )
    plans = cast(
        "tuple[felt.Plan, ...]", ()
    )  # no annotation, which Blender would evaluate at registration

    def invoke(self, context: Context, event: Event) -> set[str]:
        try:
            self.plans = self._planned(context)
        except ValueError as error:
            self.warn(str(error))
            return {"CANCELLED"}
        return context.window_manager.invoke_props_dialog(
            self, width=380, confirm_text=self.bl_label
        )

    def check(self, context: Context) -> bool:
        self.plans = self._planned(context)
        return True

    def draw(self, context: Context) -> None:
        layout = self.layout
        layout.prop(self, "margin")
        row = layout.row(align=True)
        for name in ("use_amplitude", "use_frequency", "use_material"):
            row.prop(self, name, toggle=True)
        for planned in self.plans:
            column = layout.box().column(align=True)
            _draw_row(
                column,
                planned.listener,
                levels.margin_words(planned.before),
                levels.margin_words(planned.after),
            )
            for change in planned.changes:
                _draw_row(
                    column,
                    f"{ui_text(_NAMES[change.kind])}: {change.name}",
                    f"{change.before:.3g}",
                    f"{change.after:.3g}",
                )
            if not planned.changes and planned.before < self.margin - _NEAR:
                column.label(text="Not felt by these means: nothing is changed", icon="ERROR")

    def apply(self, context: Context) -> None:
        self.plans = self._planned(context)
        for planned in self.plans:
            for change in planned.changes:
                _make(context.scene, change)
        traced = _traced_now(context)
        shown = {level.listener: level.margin for level in levels.shown_levels(traced, False)}
        left = [name for planned in self.plans if not shown[name := planned.listener] > 0]
        least = min(self.plans, key=lambda planned: shown[planned.listener]).listener
        if len(left) == len(self.plans):
            best = max(self.plans, key=lambda planned: planned.after)
            raise Refused(
                "'{}' can't be felt by these means, at best with a margin of {}: nothing is "
                "changed. Bring a source nearer, or close a gap",
                best.listener,
                levels.margin_words(best.after),
            )
        self.report(
            {"WARNING" if left else "INFO"},
            report_text(
                "Felt now; the least margin is {} at '{}'"
                if not left
                else "Felt now, except by: {1}",
                levels.margin_words(shown[least]),
                ", ".join(left) or least,
            ),
        )

    def _planned(self, context: Context) -> tuple[felt.Plan, ...]:
        """The changes for each listener, which also count for those after it."""
        traced = _traced_now(context)
        selected = [
            obj.name_full for obj in context.selected_objects if obj.haptics.listener.enabled
        ]
        names = [self.listener] if self.listener and self.listener not in selected else selected
        if not names:
            raise Refused("Select a listener first")
        result = traced.result
        plans = []
        means = _means(
            context.scene, traced, names, self.use_amplitude, self.use_frequency, self.use_material
        )
        for name in names:
            if name not in means.listeners:
                raise Refused(
                    "'{}' can't be changed: its gain is animated, it is linked from a library, or "
                    "no listener any more",
                    name,
                )
            planned = felt.plan(result, traced.settings, name, self.margin, means)
            if planned.before == -math.inf:
                raise Refused("Nothing reaches '{}'; the reason is in Why", name)
            plans.append(planned)
            result = planned.result
        return tuple(plans)


_NAMES = {
    "gain": "Gain",
    "amplitude": "Amplitude",
    "frequency": "Frequency (Hz)",
    "material": "K = (1 - κ) ρ",
}
"""Names of the changes by the values of `felt.ChangeKind`."""


def _draw_row(layout: UILayout, name: str, before: str, after: str) -> None:
    show_pair(layout, name, f"{before} \N{RIGHTWARDS ARROW} {after}", 0.65)


def _traced_now(context: Context) -> sessions.Traced:
    """The current frame, after waiting for its trace. Raises Refused if it can't be traced."""
    session.trace(context.scene, context.evaluated_depsgraph_get(), live=True)
    traced = sessions.shown(context.scene)
    if traced is None:
        raise Refused(why_untraced(session.problems_of(context.scene)))
    return traced


def _means(
    scene: Scene,
    traced: sessions.Traced,
    names: list[str],
    amplitudes: bool,
    frequencies: bool,
    materials: bool,
) -> felt.Means:
    """What may be changed: all of the following that is editable and not animated.

    Args:
        scene: with the library of materials.
        traced: the current frame.
        names: of the listeners whose gains may change.
        amplitudes: whether those of sources may change.
        frequencies: whether those of sources may change.
        materials: whether materials may change.
    """
    result, library = traced.result, scene.haptics.materials.items
    known = {item.name for item in result.listeners}
    free: dict[str, tuple[str, ...]] = {}
    if materials:
        own = [
            item.name
            for item in result.graph.table.objects
            if item.material not in library and _is_free(item.name, "haptics.kappa")
        ]
        free = {name: (name,) for name in own} | {
            item.name: made for item in library if (made := _made_of(traced, item.name))
        }
    return felt.Means(
        listeners=frozenset(
            name for name in names if name in known and _is_free(name, "haptics.listener.gain")
        ),
        loud=frozenset(
            item.name
            for item in result.sources
            if amplitudes and _is_free(item.name, "haptics.source.amplitude")
        ),
        tuned=frozenset(
            item.name
            for item in result.sources
            if frequencies and _is_free(item.name, "haptics.source.frequency")
        ),
        materials=free,
    )


def _is_free(name: str, path: str) -> bool:
    """Whether an object has a property that can be edited and that no animation sets."""
    obj = bpy.data.objects.get(name)
    return obj is not None and is_editable(obj) and not is_animated(obj, {path})


def _make(scene: Scene, change: felt.Change) -> None:
    """Write a change to the listener, source or material."""
    if change.kind is felt.ChangeKind.MATERIAL:
        owner = (
            scene.haptics.materials.items.get(change.name) or bpy.data.objects[change.name].haptics
        )
        kappa, rho = coefficients_of(change.after, owner.rho)
        if owner.rho != rho:
            owner.rho = rho
        owner.kappa = kappa
        return
    haptics = bpy.data.objects[change.name].haptics
    setattr(
        haptics.listener if change.kind is felt.ChangeKind.GAIN else haptics.source,
        change.kind,
        change.after,
    )


class HAPTIC_OT_design_by_wish(Edit):
    """Choose κ of the free materials, and ρ where that is not enough, so that the listeners with a wish have the wished level"""

    bl_label = "Fulfil Wishes"

    def apply(self, context: Context) -> None:
        scene = context.scene
        missing: dict[str, float] = {}
        for remaining in reversed(range(_ROUNDS + 1)):
            traced = _traced_now(context)
            if scene.haptics.mode not in ("HT", "SD"):
                raise Refused("Materials count in modes HT and SD only")
            shown = {level.listener: level for level in levels.shown_levels(traced, False)}
            owners = {
                name: bpy.data.objects[name].haptics.listener
                for name in shown
                if name in bpy.data.objects
            }
            missing = {
                name: owner.wish - shown[name].rms
                for name, owner in owners.items()
                if owner.use_wish
            }
            free = [
                item
                for item in scene.haptics.materials.items
                if item.is_free and _made_of(traced, item.name)
            ]
            if not missing or not free:
                raise Refused(
                    "Give a listener a wished level, and mark a material that objects are "
                    "made of as free"
                )
            if (
                not remaining
                or max(map(abs, missing.values())) < _NEAR
                or not _change(traced, missing, free)
            ):
                break
        self._say(missing)

    def _say(self, missing: dict[str, float]) -> None:
        """Report which wishes are not met."""
        left = [f"{name} {-rest:+.1f} dB" for name, rest in missing.items() if abs(rest) > _MISSED]
        if left:
            self.warn(
                "{} of {} wishes are met; off by: {}. Free more materials, widen their bounds, "
                "or change a source",
                len(missing) - len(left),
                len(missing),
                ", ".join(left),
            )
        else:
            self.tell("All {} wishes are met within a decibel", len(missing))


def _made_of(traced: sessions.Traced, material: str) -> tuple[str, ...]:
    """The haptic objects of a frame with a material of the library."""
    return tuple(
        item.name for item in traced.result.graph.table.objects if item.material == material
    )


def _change(traced: sessions.Traced, missing: dict[str, float], free: list[Any]) -> bool:
    """Set the free materials to values with nearer levels. Returns False if none changes."""
    result = traced.result
    wished = [wishes.Wish(name, rest) for name, rest in missing.items() if math.isfinite(rest)]
    bounds = [
        wishes.FreeMaterial(
            _made_of(traced, item.name), item.least_k, max(item.least_k, item.most_k)
        )
        for item in free
    ]
    answer = wishes.fulfil(
        result.graph, traced.settings, spectra.source_energies(result.sources), wished, bounds
    )
    changed = False
    for item, k in zip(free, answer.k, strict=True):
        if abs(transfer_coefficient(item.kappa, item.rho) - k) > 1e-4 * k:
            kappa, rho = coefficients_of(k, item.rho)
            if item.rho != rho:
                item.rho = rho
            item.kappa = kappa
            changed = True
    return changed


def _is_chosen(context: Context) -> bool:
    """Whether everything is chosen that a fit needs."""
    chosen = context.scene.haptics.materials.fit
    names = "source_file", "listener_file", "source", "listener", "object"
    return all(getattr(chosen, name) for name in names)


class HAPTIC_OT_fit_material(Action):
    """Set the loss of a material, and the gain of a contact, so that the scene transmits vibration as two recordings show"""

    bl_label = "Fit Material"
    bl_options = {"REGISTER"}

    needs = (Need(_is_chosen, _CHOOSE), OBJECT_MODE)

    def apply(self, context: Context) -> set[str]:
        scene = context.scene
        chosen = scene.haptics.materials.fit
        traced = _traced_now(context)
        if chosen.object is None or not is_editable(chosen.object):
            raise TranslatedError(LINKED)
        read = recordings.read_recordings(
            *(Path(bpy.path.abspath(path)) for path in (chosen.source_file, chosen.listener_file))
        )
        reports: list[job.Report] = []
        work = _steps(scene, traced.result.graph, read, reports)
        return job.run(
            self, context, job.Job("Fit Material", len(read.starts), work, lambda _: reports)
        )


def _steps(
    scene: Scene, graph: HapticGraph, read: recordings.Recordings, reports: list[job.Report]
) -> Iterator[None]:
    """Average the recordings window by window, then fit, as one undo step."""
    yield from read.steps()
    chosen = scene.haptics.materials.fit
    if chosen.object is None or chosen.source is None or chosen.listener is None:
        raise TranslatedError(_CHOOSE)
    item = scene.haptics.materials.items.get(chosen.object.haptics.material.name)
    names = [
        o.name for o in graph.table.objects if item is not None and o.material == item.name
    ] or [chosen.object.name_full]
    contact = (
        (chosen.first.name_full, chosen.second.name_full)
        if chosen.is_calibrated and chosen.first and chosen.second
        else ()
    )
    asked = recordings.Question(
        chosen.source.name_full,
        chosen.listener.name_full,
        tuple(names),
        contact,
        chosen.is_calibrated,
    )
    found = recordings.fit(graph, read.transfer(), asked)
    owner = item or chosen.object.haptics
    kappa, rho = coefficients_of(found.k, owner.rho)
    owner.rho, owner.kappa = rho, kappa
    if contact:
        _set_gain(scene, contact, found.gain)
    chosen.fitted = item.name if item is not None else names[0]
    error = found.gain * (math.exp(found.contact_error) - 1)
    chosen.values = (
        found.damping,
        found.damping_error,
        found.gain,
        error,
        found.before,
        found.after,
    )
    chosen.bands = found.bands.ravel()
    chosen.doubts = "\n".join(map(sentence, found.doubts))
    bpy.ops.ed.undo_push(message="Fit Material")
    reports.append(
        (
            {"WARNING" if found.doubts else "INFO"},
            report_text(
                "The model missed the recordings by {:.1f} dB, and misses them by {:.1f} dB now",
                found.before,
                found.after,
            ),
        )
    )


def _set_gain(scene: Scene, contact: tuple[str, str], gain: float) -> None:
    """Set the gain of contacts of two objects in the rule for this pair, which is added if
    missing."""
    rules: Any = scene.haptics.transmission_table.items
    own = [
        r
        for r in rules
        if (r.first_kind, r.second_kind) == ("OBJECT", "OBJECT")
        and {r.first, r.second} == set(contact)
    ]
    rule = own[0] if own else rules.add()
    rule.first_kind = rule.second_kind = "OBJECT"
    rule.first, rule.second = contact
    rule.function, rule.constant = "constant", gain
