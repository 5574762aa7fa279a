"""The tagged objects of a scene as authored, and lists derived from them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from ...core.arrays import FloatArray, IntArray
from ...core.contacts.nearest_point import nearest_to_origin
from ...core.contacts.settings import Body
from ...core.contacts.surface_shape import SurfaceShape
from ...core.contacts.tracker import STILL
from ...core.frozen import frozen
from ...core.scene.values import HapticObject, Listener, Source
from .problem import Problem


@frozen
class Tagged:
    """An object of Blender with a haptic role (*tagged*), as values of the core."""

    row: int  # in bpy.data.objects
    animated: tuple[str, ...] | None  # data paths, see `compatibility.animated_paths`
    stretch: tuple[float, ...]  # see `rigid_transforms`
    object: HapticObject | None = None
    body: Body | None = None
    surface: SurfaceShape | None = None
    source: Source | None = None
    listener: Listener | None = None
    problems: tuple[Problem, ...] = ()


@frozen
class TaggedLists:
    """The tagged objects of a scene as lists, in the order of their rows.

    Attributes:
        rows: (m,) of the tagged objects in ``bpy.data.objects``.
        stretches: (m, 6) of these in the world.
        still: (m, 16) changes of their world matrices that move no corner by more than about
            `STILL`, and count as rest.
        animated: rows of those with animated properties.
        of_bodies: (n,) which of the tagged objects are haptic objects.
        of_places: (k,) rows of the sources and listeners.
        objects, bodies: the n haptic objects, and these for the tracker.
        hulls: shapes of the objects, by name, whose convex hull deviates from their surface.
        places: the k sources and listeners, without their positions in a frame.
        problems: of all tagged objects.
    """

    rows: IntArray
    stretches: FloatArray
    still: FloatArray
    animated: tuple[int, ...]
    of_bodies: IntArray
    of_places: IntArray
    objects: tuple[HapticObject, ...]
    bodies: tuple[Body, ...]
    hulls: Mapping[str, SurfaceShape]
    places: tuple[Source | Listener, ...]
    problems: tuple[Problem, ...]

    @property
    def are_triggered(self) -> bool:
        """Whether any source has triggers."""
        return any(isinstance(item, Source) and item.triggers is not None for item in self.places)

    @classmethod
    def of(cls, by_row: Mapping[int, Tagged], before: TaggedLists | None = None) -> TaggedLists:
        """The lists of the tagged objects. ``before``: those of the frame before, of which remains
        what is unchanged."""
        tagged = sorted(by_row.values(), key=lambda t: t.row)
        bodies = [
            (k, t.object, t.body)
            for k, t in enumerate(tagged)
            if t.object is not None and t.body is not None
        ]
        # Roles on an object with a problem, or a hidden one, are left out.
        sound = {item.name for _, item, _ in bodies}
        places = [
            (t.row, item)
            for t in tagged
            for item in (t.source, t.listener)
            if item is not None and item.object in sound
        ]
        objects = tuple(item for _, item, _ in bodies)
        alone = tuple(body for _, _, body in bodies)
        still = (
            before.still
            if before is not None and alone == before.bodies
            else _still([t.stretch for t in tagged], bodies, before)
        )
        return cls(
            rows=np.array([t.row for t in tagged], dtype=np.int64),
            stretches=np.array([t.stretch for t in tagged], dtype=np.float64).reshape(-1, 6),
            still=still,
            animated=tuple(t.row for t in tagged if t.animated != ()),
            of_bodies=np.array([k for k, _, _ in bodies], dtype=np.int64),
            of_places=np.array([row for row, _ in places], dtype=np.int64),
            objects=objects,
            bodies=alone,
            hulls=_hulls(tagged),
            places=tuple(item for _, item in places),
            problems=tuple(dict.fromkeys(problem for t in tagged for problem in t.problems)),
        )

    def anchors(self) -> FloatArray:
        """Where the sources and listeners stand in the rotated frames of their objects (k, 3) [m]:
        at the origin, or, where that is outside the object's own body, on the surface."""
        shapes = {body.name: body.shape for body in self.bodies}
        places = [
            nearest_to_origin(shapes[item.object]) if item.name == item.object else np.zeros(3)
            for item in self.places
        ]
        return np.array(places, dtype=np.float64).reshape(-1, 3)

    def reshaped(self, changed: Mapping[int, Tagged]) -> TaggedLists:
        """The lists after a change of nothing but the shapes of some objects, by row."""
        bodies, hulls, still = list(self.bodies), dict(self.hulls), self.still.copy()
        for row, tagged in changed.items():
            assert tagged.object is not None and tagged.body is not None
            number = int(self.rows.searchsorted(row))
            bodies[int(self.of_bodies.searchsorted(number))] = tagged.body
            still[number, :12] = _still_axes([tagged.stretch], [tagged.body])
            hulls.pop(tagged.object.name, None)
            hulls |= _hulls([tagged])
        return replace(self, bodies=tuple(bodies), hulls=hulls, still=still)


def _hulls(tagged: Iterable[Tagged]) -> dict[str, SurfaceShape]:
    """The shapes of haptic objects, by name, whose convex hull deviates from their surface."""
    return {
        t.object.name: t.surface
        for t in tagged
        if t.object is not None and t.surface is not None and t.surface.deviation > 0
    }


def _still(
    stretches: list[tuple[float, ...]],
    bodies: list[tuple[int, HapticObject, Body]],
    before: TaggedLists | None,
) -> FloatArray:
    """Of objects with these ``stretches``, the limits of changes of world matrices (m, 16), column
    by column. Those of the same bodies are taken from ``before``."""
    limits = np.full((len(stretches), 16), STILL)
    if before is not None:
        kept = dict(zip(map(id, before.bodies), before.of_bodies.tolist(), strict=True))
        same = [k for k, _, body in bodies if kept.get(id(body)) == k]
        limits[same] = before.still[same]
        bodies = [item for item in bodies if kept.get(id(item[2])) != item[0]]
    if bodies:
        limits[[k for k, _, _ in bodies], :12] = _still_axes(
            [stretches[k] for k, _, _ in bodies], [body for _, _, body in bodies]
        )
    return limits


def _still_axes(stretches: Sequence[tuple[float, ...]], bodies: Sequence[Body]) -> FloatArray:
    """The limits of changes of the axes (n, 12) in the world matrices of bodies: that of a turn is
    less the further their corners are away."""
    reach = np.abs([body.shape.local_bounds for body in bodies]).max(axis=1)
    arm = np.linalg.norm(reach, axis=1)[:, None].clip(1e-9)
    return np.asarray(STILL * (np.abs(stretches)[:, :3].repeat(4, axis=1) / arm))
