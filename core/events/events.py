"""All kinds of events, from frame to frame."""

from __future__ import annotations

import copy
from collections.abc import Mapping

from ..contacts.tracker import FrameContacts
from ..scene.rules import ContactSettings
from ..scene.values import Source
from .frame import Frame
from .impacts import Impacts
from .one_shots import OneShots
from .rubbing import Rubbing
from .stored import FrameEvents


class Events:
    """One-shots, sliding and rolling, and impacts."""

    def __init__(self) -> None:
        self.shots = OneShots()
        self.rubbing = Rubbing()
        self.impacts = Impacts()

    def copy(self) -> Events:
        """Events that follow other frames from here on."""
        found = copy.copy(self)
        found.shots = copy.copy(self.shots)
        found.rubbing = copy.copy(self.rubbing)
        found.impacts = copy.copy(self.impacts)
        return found

    def clear(self) -> None:
        """Drop all events."""
        self.shots.clear()
        self.rubbing.clear()
        self.impacts.clear()

    def set_delays(self, delays: Mapping[str, float]) -> None:
        """Extend sources by their largest delays at the listeners [s], given by name."""
        self.shots.delays = self.impacts.delays = delays

    def history(self) -> str:
        """The state that later frames depend on."""
        names = tuple(item.source.name for item in self.impacts.active)
        return repr((names, self.shots.active)) + self.rubbing.history()

    def restore(self, kept: FrameEvents | None, frame: Frame, settings: ContactSettings) -> None:
        """Return to the events ``kept`` of a ``frame``."""
        if kept is None:
            self.clear()
            return
        self.shots.restore(kept.shots, kept.start, frame)
        self.rubbing.restore(kept.rubbed)
        self.impacts.restore(kept.impacts, kept.start, frame, settings)

    def follow(
        self, frame: Frame, since: float | None, found: FrameContacts, settings: ContactSettings
    ) -> tuple[Source, ...]:
        """The temporary sources of a ``frame`` with the contacts ``found`` in it; ``since``: the
        time of the frame before [s], None without one. Those of impacts are the last, and of these
        the ones that begin."""
        given = frame, since, found, settings
        return (
            *self.shots.follow(frame, since),
            *self.rubbing.follow(*given),
            *self.impacts.follow(*given),
        )

    def snapshot(self, start: float, frame: Frame) -> FrameEvents | None:
        """What `restore` needs of a ``frame`` that begins at ``start`` [s]; None if nothing is
        active."""
        if frame.transforms is None:
            return None
        return FrameEvents.of(
            start,
            frame.transforms,
            self.impacts.snapshot(),
            self.shots.snapshot(),
            self.rubbing.snapshot(),
        )
