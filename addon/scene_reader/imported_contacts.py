"""Poses of bodies in an imported file, and the contacts between them."""

from __future__ import annotations

from itertools import compress

import numpy as np
from bpy.types import Scene

from ...core.arrays import FloatArray
from ...core.contacts.authored import AuthoredContacts
from ...core.contacts.settings import ContactSettings
from ...core.contacts.shapes import pose_matrix
from ...core.frozen import frozen
from ...core.scene.values import Pose
from ...core.unchanged import Unchanged
from .imported import NEAR, FileContacts, file_contacts, stored_item


@frozen(eq=False)
class FilePoses:
    """Poses of the bodies in the file that the scene was imported from.

    Attributes:
        names: of the bodies.
        poses: by body, None where the file has none.
        transforms: (n, 4, 4) of these poses, infinite without one.
        limits: (n, 4, 4) deviations from ``transforms`` up to which a body has not moved.
    """

    names: tuple[str, ...]
    poses: tuple[Pose | None, ...]
    transforms: FloatArray
    limits: FloatArray

    @classmethod
    def of(cls, names: tuple[str, ...], poses: tuple[Pose | None, ...]) -> FilePoses:
        transforms = np.full((len(poses), 4, 4), np.inf)
        for row, pose in enumerate(poses):
            if pose is not None:
                transforms[row] = pose_matrix(pose)
        limits = np.full((len(poses), 4, 4), 2 * NEAR)
        far = np.abs(transforms[:, :3, 3]).max(axis=1, initial=1.0)
        limits[:, :3, 3] = NEAR * np.where(np.isfinite(far), far, 1.0)[:, None]
        return cls(names, poses, transforms, limits)

    def snap(self, transforms: FloatArray) -> frozenset[str]:
        """Names of the bodies that have not moved since the import. Their rows of ``transforms``
        (n, 4, 4) are replaced by the poses of the file, which are not rounded to single
        precision."""
        if not np.isfinite(self.transforms[:, 3, 3]).any():
            return frozenset()
        unmoved = np.all(np.abs(transforms - self.transforms) <= self.limits, axis=(1, 2))
        transforms[unmoved] = self.transforms[unmoved]
        return frozenset(compress(self.names, unmoved.tolist()))


class ImportedContacts:
    """The contacts that a scene was imported with. ``problems``: their faults as messages."""

    def __init__(self) -> None:
        self.problems: tuple[str, ...] = ()
        self._kept = FileContacts()
        self._authored = Unchanged(_authored)

    def read(self, scene: Scene) -> None:
        """Read the stored contacts of the scene again."""
        try:
            for name in ("settings", "rules"):
                stored_item(scene.haptics.imported, name)
            self._kept = file_contacts(scene.haptics.imported_contacts)
            self.problems = ()
        except ValueError as error:
            self._kept = FileContacts()
            self.problems = (str(error),)

    def authored(
        self, file_poses: FilePoses, settled: frozenset[str], settings: ContactSettings
    ) -> AuthoredContacts | None:
        """The contacts of the file that are still valid, those between bodies that are ``settled``
        (in their poses of the file), as the tracer takes them; None without any."""
        kept = self._kept
        settled = settled if kept.tolerance == settings.tolerance and kept.contacts else frozenset()
        if not settled and not kept.transmissions:
            return None
        return self._authored(kept, file_poses, settled)


def _authored(
    kept: FileContacts, file_poses: FilePoses, settled: frozenset[str]
) -> AuthoredContacts:
    pairs = (items for pair, items in kept.contacts.items() if settled.issuperset(pair))
    contacts = [item for items in pairs for item in items]
    return AuthoredContacts.of(file_poses.names, settled, contacts, kept.transmissions)
