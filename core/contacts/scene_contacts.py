"""The contacts of a scene at rest, from the shapes and poses of its objects."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..scene.values import HapticScene, Pose
from .contact_set import ContactSet
from .settings import Body, Motion
from .shapes import pose_matrix
from .tracker import ContactTracker
from .transmissions import TransmissionRules


def contacts_of_scene(scene: HapticScene, tolerance: float | None = None) -> ContactSet:
    """Contacts between the objects of ``scene`` that have a shape; without a pose they stand at the
    origin. ``pairs`` are numbers in ``scene.objects``. Two touch when their signed distance,
    margins included, is at most ``tolerance`` metres, by default that of the scene's rules.

    Raises ValueError that names the object where a shape can't be used.
    """
    chosen = [number for number, item in enumerate(scene.objects) if item.shape is not None]
    objects = [scene.objects[n] for n in chosen]
    bodies = [
        Body(item.name, item.shape, item.mass, Motion.KINEMATIC, item.medium, item.material)
        for item in objects
    ]
    rules = scene.rules if tolerance is None else replace(scene.rules, tolerance=tolerance)
    tracker = ContactTracker(bodies, rules)
    transforms = np.array(
        [pose_matrix(item.pose or Pose()) for item in objects], dtype=np.float64
    ).reshape(-1, 4, 4)
    frame = tracker.update(0.0, transforms)
    if frame.warnings:
        raise ValueError(f"{frame.warnings[0].object}: its transform is not finite")
    contacts = replace(frame.contacts, pairs=np.array(chosen, dtype=np.int64)[frame.contacts.pairs])
    return TransmissionRules(
        rules.transmission_table, [(item.name, item.material) for item in scene.objects]
    ).over(contacts)
