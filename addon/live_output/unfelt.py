"""Reasons for which connected devices do not play a listener."""

from __future__ import annotations

from bpy.types import Scene

from ..blender.words import ui_text
from ..session import sessions
from ..translations.sentences import sentence
from . import handlers, outputs, player


def device_words(scene: Scene, listener: str) -> str:
    """The reason for which no connected device plays the listener; "" if one does, or if no device
    is connected."""
    traced = sessions.shown(scene)
    if traced is None or not outputs.running():
        return ""
    result = traced.result
    names = [item.name for item in result.listeners]
    if listener not in names:
        return ""
    mapping = player.mapping_of(result, handlers.choices(result))
    column = names.index(listener)
    if any(weights[:, column].any() for weights in mapping.weights.values()):
        return ""
    losses = [loss.message for loss in mapping.losses if loss.listener == listener]
    return (
        sentence(losses[0])
        if losses
        else ui_text("'{}' is muted: no actuator is chosen for it", listener)
    )
