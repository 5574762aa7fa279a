"""When the gains of the last frame are those of this one."""

from __future__ import annotations

import dataclasses

import numpy as np
from haptic_tracing.core.contacts.contact_set import ContactSet
from haptic_tracing.core.contacts.shapes import Box
from haptic_tracing.core.graph.haptic_graph import ObjectTable
from haptic_tracing.core.graph.object_frames import ObjectFrames
from haptic_tracing.core.propagation.reuse import Inputs
from haptic_tracing.core.scene.functions import Exponential
from haptic_tracing.core.scene.values import (
    Contact,
    HapticObject,
    Listener,
    Pose,
    Settings,
    Source,
)

TURNED = (float(np.cos(0.3)), 0.0, 0.0, float(np.sin(0.3)))


def inputs(pose: Pose) -> Inputs:
    """Posts on a floor that damps within half a metre and lies in ``pose``; everything else stays
    where it is."""
    floor = HapticObject("floor", 0, 1, Exponential(alpha=2.0), shape=Box((8, 8, 1)), pose=pose)
    table = ObjectTable.of(
        [floor, *(HapticObject(name, 0, 1, Exponential(alpha=2.0)) for name in "abcdef")], 0.1
    )
    places = (
        (1.3, 0.2, 0.5),
        (-0.4, 1.1, 0.5),
        (1.0, 0.5, 0.5),
        (0.6, 0.6, 0.5),
        (0.2, 0.9, 0.5),
        (-0.1, 0.9, 0.5),
    )
    touching = [
        Contact((name, "floor"), (at, at)) for name, at in zip("abcdef", places, strict=True)
    ]
    contacts = ContactSet.from_contacts(touching, table.index())
    ends = (Source("s", "a", (1.3, 0.2, 1.0)),), (Listener("l", "b", (-0.4, 1.1, 1.0), radius=0.0),)
    frames = ObjectFrames.of_objects(table.objects)
    return Inputs(table, contacts, *ends, Settings(), frames)


def test_what_stands_still_is_not_computed_again():
    """Also where nothing asks for frames."""
    one = inputs(Pose())
    again = inputs(Pose())
    assert one == one._replace(frames=again.frames)
    plain = one._replace(frames=None)
    assert plain == plain._replace(sources=tuple(map(dataclasses.replace, plain.sources)))
    assert plain != one
