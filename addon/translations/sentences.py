"""Messages of the core as sentences in the language of Blender's interface."""

from __future__ import annotations

from bpy.app.translations import pgettext_iface as iface_

from ...core import message as messages


def sentence(message: messages.Message) -> str:
    """A sentence without a full stop; in English where the language has no translation."""
    return messages.sentence(message, iface_(message.cause.value))
