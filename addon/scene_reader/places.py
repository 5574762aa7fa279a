"""Where the haptic objects, sources and listeners of a scene are."""

from __future__ import annotations

import numpy as np

from ...core.scene.values import Listener, Source
from .poses import Poses
from .tagged import TaggedLists


class Places:
    """The places in a frame. ``transforms`` (n, 4, 4): rigid, of the bodies. ``roles``: the sources
    and listeners at their positions."""

    def __init__(self) -> None:
        self.transforms = np.zeros((0, 4, 4))
        self.roles: list[Source | Listener] = []
        self._anchors = np.zeros((0, 3))  # see `TaggedLists.anchors`
        self._lists: TaggedLists | None = None

    def follow(self, lists: TaggedLists, poses: Poses) -> None:
        """Take over where things are, if the lists are others or anything has moved."""
        if lists is not self._lists:
            self._anchors = lists.anchors()
        elif not poses.are_moved:
            return
        self._lists = lists
        self.transforms = poses.rigid.take(lists.of_bodies, axis=0)
        on = poses.rigid[lists.rows.searchsorted(lists.of_places), :3]
        places = (on[..., :3] @ self._anchors[..., None])[..., 0] + on[..., 3]
        self.roles = [
            item.moved(place) for place, item in zip(places.tolist(), lists.places, strict=True)
        ]
