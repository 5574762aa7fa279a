"""Events: changes that modules above subscribe to and must follow at once."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any


class Event:
    """A kind of change. Calling it calls every subscriber with the same arguments."""

    def __init__(self) -> None:
        self._subscribers: list[Callable[..., None]] = []

    def subscribe(self, subscriber: Callable[..., None]) -> None:
        """Call ``subscriber`` from now on."""
        self._subscribers.append(subscriber)

    def unsubscribe(self, subscriber: Callable[..., None]) -> None:
        """No longer call ``subscriber``; no effect if it is not subscribed."""
        if subscriber in self._subscribers:
            self._subscribers.remove(subscriber)

    def __call__(self, *arguments: Any) -> None:
        for subscriber in tuple(self._subscribers):
            subscriber(*arguments)


device_adjusted = Event()
"""The settings of a device (HapticDeviceProperties)."""
preview_adjusted = Event()
"""The settings of the preview as sound (HapticLiveOutputProperties)."""
made_haptic = Event()
"""An object became haptic by its property."""
mode_changed = Event()
"""Another haptic mode was chosen for a scene that is not traced at every edit."""
file_changed = Event()
"""Another file is loaded, or the add-on is disabled: everything cached about scenes is invalid."""
disabled = Event()
"""The add-on is disabled and frees its resources."""
