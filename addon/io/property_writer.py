"""Conversion of the objects, sources, listeners and rules of a haptic scene to Blender's
properties."""

from __future__ import annotations

from collections.abc import Collection
from typing import Any

from ...core.formats.scene.values_json import item_to_dict
from ...core.scene.functions import ModulationFunction
from ...core.scene.impact_rule import ImpactRule, ImpactTemplates
from ...core.scene.rules import ContactSettings
from ...core.scene.texture import Texture
from ...core.scene.values import HapticObject, Listener, Source, SourceKind, TriggerKind
from ...core.signals import DEFAULT_PERSISTENT, Decay, Product, Signal
from ..blender.single_precision import shortest
from ..properties.declared import identifier, write_values
from ..properties.signal_kinds import kind_of
from ..scene_reader.imported import text_of


def write_body(haptics: Any, item: HapticObject) -> None:
    """Set an object's properties to ``item``."""
    write_values(haptics, item)
    function = item.propagation
    is_known = _choose(haptics, "function", function.name)
    haptics.enabled = True
    if is_known:
        write_values(haptics, function)
        write_values(haptics, function.spectrum)
        haptics.material.use_bands = bool(function.spectrum.band_decays)
        if function.spectrum.band_decays:
            write_values(haptics.material, function.spectrum)


def write_source(source: Any, item: Source, placed: bool = True) -> None:
    """Set a source's properties to ``item``; ``placed``: store its world position as well."""
    source.enabled = True
    write_values(source, item)
    signal, source.decay = item.signal, 0.0
    if item.kind is SourceKind.PERSISTENT:
        signal, source.decay = _without_decay(signal or DEFAULT_PERSISTENT)
    kept = _write_signal(source, signal)
    source.one_shot = item.triggers is not None
    source.trigger_hit = any(trigger.on is TriggerKind.HIT for trigger in item.triggers or ())
    triggers = [
        item_to_dict(trigger)
        for trigger in item.triggers or ()
        if trigger.on is not TriggerKind.HIT
    ]
    without = (
        "signal",
        "triggers",
        *(() if placed else ("position", "second_object", "second_position")),
    )
    source.imported = stored_text(item, without, signal=kept and kept.to_dict(), triggers=triggers)


def write_listener(listener: Any, item: Listener, placed: bool = True) -> list[str]:
    """Set a listener's properties, as `write_source` does. Returns sentences about losses."""
    listener.enabled = True
    listener.imported = stored_text(item, () if placed else ("position",))
    return write_values(listener, item)


def stored_text(item: Any, without: Collection[str] = (), **others: Any) -> str:
    """The text that stores an item, except its name, its object, and the fields ``without``,
    together with ``others``."""
    form = {
        key: value
        for key, value in item_to_dict(item).items()
        if key not in ("name", "object", *without)
    }
    return text_of(**{**form, **others})


def write_tables(haptics: Any, rules: ContactSettings) -> None:
    """Replace the rows of a scene's tables by those of ``rules``."""
    for name, write in (
        ("impact_table", _write_impact_rule),
        ("transmission_table", _write_transmission),
        ("textures", _write_texture),
    ):
        rows = getattr(haptics, name).items
        rows.clear()
        for rule in getattr(rules, name).rows:
            row = rows.add()
            for side, key in zip(rule.between, ("first", "second"), strict=True):
                setattr(
                    row,
                    f"{key}_kind",
                    "OBJECT" if side.object else "MATERIAL" if side.material else "ANY",
                )
                setattr(row, key, side.object or side.material)
            write(row, rule.value)


def _write_transmission(row: Any, function: ModulationFunction) -> None:
    """Set a row's properties to ``function``; a function not available for contacts becomes the
    identity."""
    if not _choose(row, "function", function.name):
        row.function = "identity"
        return
    write_values(row, function)
    row.imported = text_of(transmission=function.to_dict())


def _write_impact_rule(row: Any, rule: ImpactRule) -> None:
    """Set a row's properties to ``rule``."""
    write_values(row, rule)
    row.use_limits = rule.limits is not None
    if rule.limits is not None:
        write_values(row, rule.limits)
    row.template = (
        identifier(rule.template) if isinstance(rule.template, ImpactTemplates) else "KEPT"
    )
    row.imported = stored_text(rule)


def _write_texture(row: Any, texture: Texture) -> None:
    """Set a row's properties to ``texture``."""
    write_values(row, texture)
    row.imported = stored_text(texture)


def _without_decay(signal: Signal | None) -> tuple[Signal | None, float]:
    """A signal without its decay, and its decay time [s], 0 without a decay."""
    match signal:
        case Product(of=(worn, Decay(time_constant=seconds))) if shortest(seconds) == seconds:
            return worn, seconds
    return signal, 0.0


def _write_signal(source: Any, signal: Signal | None) -> Signal | None:
    """Choose the equivalent signal of the properties; otherwise the imported one, which is returned
    to be stored."""
    known = kind_of(signal)
    if known is None:
        source.signal = "KEPT"
        return signal
    source.signal, source.frequency = known
    return None


def _choose(owner: Any, name: str, value: str) -> bool:
    """Set a choice. Returns False if it does not exist."""
    if value not in owner.bl_rna.properties[name].enum_items:
        return False
    setattr(owner, name, value)
    return True
