"""The contacts of a scene at rest, from the shapes and poses of its objects."""

from __future__ import annotations

import numpy as np

from ..scene.values import HapticScene, Pose
from .contact_set import ContactSet
from .shapes import pose_matrix
from .tracker import Body, ContactSettings, ContactTracker, Motion


def contacts_of_scene(scene: HapticScene, tolerance: float = 0.01, patch_points: bool = False) -> ContactSet:
    """Contacts between the objects of ``scene`` that have a shape; without a pose they stand at the origin. ``pairs`` are numbers in
    ``scene.objects``. Two touch when their signed distance, margins included, is at most ``tolerance`` metres.

    Raises ValueError that names the object where a shape can't be used.
    """
    chosen = [number for number, item in enumerate(scene.objects) if item.shape is not None]
    objects = [scene.objects[n] for n in chosen]
    bodies = [Body(item.name, item.shape, item.mass, Motion.KINEMATIC, item.medium) for item in objects]
    tracker = ContactTracker(bodies, ContactSettings(tolerance=tolerance, patch_points=patch_points))
    transforms = np.array([pose_matrix(item.pose or Pose()) for item in objects], dtype=np.float64).reshape(-1, 4, 4)
    frame = tracker.update(0.0, transforms)
    if frame.warnings:
        raise ValueError(f"{frame.warnings[0].object}: its transform is not finite")
    contacts = frame.contacts
    return ContactSet(
        pairs=np.array(chosen, dtype=np.int64)[contacts.pairs],
        positions=contacts.positions,
        normal=contacts.normal,
        depth=contacts.depth,
        distance=contacts.distance,
        area=contacts.area,
        share=contacts.share,
        weight=contacts.weight,
        transmission=contacts.transmission,
        transmissions=contacts.transmissions,
    )
