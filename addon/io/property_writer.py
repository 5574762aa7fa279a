"""Conversion of objects, sources and listeners of a file to Blender's properties."""

from __future__ import annotations

from typing import Any

from ...core.scene.values import HapticObject, Listener, Source
from ...core.signals import DEFAULT_PERSISTENT, Decay, Product, Signal
from ..blender.single_precision import shortest
from ..properties.declared import write_values
from ..properties.signal_kinds import kind_of
from ..scene_reader.kept_signal import text_of_signal


def write_body(haptics: Any, item: HapticObject) -> None:
    """Set an object's properties to ``item``."""
    write_values(haptics, item)
    function = item.propagation
    is_known = function.name in haptics.bl_rna.properties["function"].enum_items
    if is_known:
        haptics.function = function.name
    haptics.enabled = True
    if is_known:
        write_values(haptics, function)
        write_values(haptics, function.spectrum)


def write_source(source: Any, item: Source) -> None:
    """Set a source's properties to ``item``, without its triggers."""
    source.enabled = True
    write_values(source, item)
    signal, source.decay = _without_decay(item.signal or DEFAULT_PERSISTENT)
    known = kind_of(signal)
    if known is None:
        source.signal, source.kept = "KEPT", text_of_signal(signal)
    else:
        source.signal, source.frequency = known
    source.one_shot = item.triggers is not None


def write_listener(listener: Any, item: Listener) -> None:
    """Set a listener's properties to ``item``."""
    listener.enabled = True
    write_values(listener, item)


def _without_decay(signal: Signal) -> tuple[Signal, float]:
    """A signal without its decay, and its decay time [s], 0 without a decay."""
    match signal:
        case Product(of=(worn, Decay(time_constant=seconds))) if shortest(seconds) == seconds:
            return worn, seconds
    return signal, 0.0
