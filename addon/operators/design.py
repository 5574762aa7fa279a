"""The operator that changes gains, signals and materials so that a listener feels something."""

from __future__ import annotations

import math
from typing import cast

import bpy
from bpy.types import Context, Event, Scene, UILayout

from ...core import felt
from ...core.scene.coefficients import coefficients_of
from ..blender.compatibility import is_animated
from ..blender.polling import Edit, Refused, is_editable
from ..blender.words import report_text, show_pair, ui_text
from ..properties.kinds import limited, switch, text
from ..scene_reader.problem import why_untraced
from ..session import session, sessions
from ..view import levels

_NEAR = 0.1
"""Deviation [dB] up to which a margin counts as the wanted one."""


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


def _made_of(traced: sessions.Traced, material: str) -> tuple[str, ...]:
    """The haptic objects of a frame with a material of the library."""
    return tuple(
        item.name for item in traced.result.graph.table.objects if item.material == material
    )
