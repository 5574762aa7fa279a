"""How many contacts are those of convex hulls whose surfaces do not touch, for the hint that offers
the surfaces."""

from __future__ import annotations

from bpy.types import Scene

from ...core.contacts.air_contacts import contacts_through_air
from ..session.derived import Derived
from ..session.sessions import Traced


def _count(traced: Traced, *_: object) -> int:
    """Number of contacts of hulls whose surfaces are apart. Computed on the worker."""
    reading = traced.reading
    seen = (
        {}
        if reading is None
        else {name: hull.seen for name, hull in reading.hulls.items() if hull.seen is not None}
    )
    if reading is None or not seen:
        return 0
    pairs, tolerance = traced.result.contacts.pairs, reading.contact_settings.tolerance
    return contacts_through_air(reading.bodies, reading.transforms, pairs, seen, tolerance)


_COUNT: Derived[None, int] = Derived(_count)


def contacts_in_air(scene: Scene) -> int:
    """The last count, without waiting."""
    latest = _COUNT.latest(scene, None)
    return 0 if latest is None else latest.value
