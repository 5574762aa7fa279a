"""Functions that add objects, rigid bodies, haptic sources and listeners to a scene."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import bpy
from bpy.types import Material, Mesh, Object, Scene
from mathutils import Euler, Vector

from ..addon.authoring.materials import spread_all_around
from ..addon.blender.progress import show
from ..core.scene.materials import Material as Substance
from ..core.scene.materials import texture_in
from .animation import CONSTANT, animate
from .geometry import Geometry, Point, to_mesh
from .materials import tag

_expected: list[int] = []  # the number of objects of the sample that is being built


@contextmanager
def progress(objects: int) -> Iterator[None]:
    """Show progress at the mouse pointer while about ``objects`` objects are placed."""
    manager = bpy.context.window_manager
    manager.progress_begin(0, 1)
    _expected.append(objects)
    try:
        yield
    finally:
        _expected.clear()
        manager.progress_end()


def _link(scene: Scene, obj: Object) -> None:
    scene.collection.objects.link(obj)
    if _expected:
        show(min(len(scene.objects) / _expected[0], 1.0))


def place(
    scene: Scene,
    name: str,
    geometry: Geometry,
    materials: Sequence[Material],
    location: Point | Vector = (0.0, 0.0, 0.0),
    rotation: Point = (0.0, 0.0, 0.0),
    parent: Object | None = None,
) -> Object:
    """A new mesh object in ``scene``: ``geometry`` turned by ``rotation`` (XYZ, radians) and moved
    by ``location``, relative to ``parent``.

    Its origin is the centre of its bounding box, since that is where rigid bodies have the centre
    of their boxes, cylinders and cones.
    """
    centre = geometry.centre()
    mesh = to_mesh(name, geometry.moved(*(-centre)), materials)
    return place_mesh(
        scene, name, mesh, Vector(location) + Euler(rotation).to_matrix() @ centre, rotation, parent
    )


def place_mesh(
    scene: Scene,
    name: str,
    mesh: Mesh,
    location: Point | Vector,
    rotation: Point = (0.0, 0.0, 0.0),
    parent: Object | None = None,
) -> Object:
    """A new object in ``scene`` of a mesh that others may share."""
    obj = bpy.data.objects.new(name, mesh)
    _link(scene, obj)
    obj.location = location
    obj.rotation_euler = rotation
    obj.parent = parent
    return obj


def place_empty(
    scene: Scene,
    name: str,
    location: Point | Vector = (0.0, 0.0, 0.0),
    parent: Object | None = None,
    kind: str = "PLAIN_AXES",
    size: float = 0.1,
    heading: float = 0.0,
) -> Object:
    """A new empty in ``scene``, relative to ``parent``, turned by ``heading`` about z."""
    obj = bpy.data.objects.new(name, None)
    _link(scene, obj)
    obj.empty_display_type = kind
    obj.empty_display_size = size
    obj.location = location
    obj.rotation_euler = (0.0, 0.0, heading)
    obj.parent = parent
    return obj


def add_rigid_body_world(scene: Scene, end: int) -> None:
    """Give ``scene`` a rigid body world that simulates from its first frame to frame ``end``."""
    with bpy.context.temp_override(scene=scene):
        bpy.ops.rigidbody.world_add()
    world = scene.rigidbody_world
    world.collection = bpy.data.collections.new(f"{scene.name} Rigid Bodies")
    world.constraints = bpy.data.collections.new(f"{scene.name} Rigid Body Constraints")
    world.point_cache.frame_start = scene.frame_start
    world.point_cache.frame_end = end


def _rigid_body(scene: Scene, obj: Object, shape: str) -> bpy.types.RigidBodyObject:
    scene.rigidbody_world.collection.objects.link(obj)
    body: Any = obj.rigid_body
    body.collision_shape = shape
    # By default every shape has a margin of 4 cm, which thickens thin boards.
    body.use_margin = True
    body.collision_margin = 0.0
    return body


def make_static(
    scene: Scene,
    obj: Object,
    substance: Substance,
    shape: str = "CONVEX_HULL",
    friction: float = 0.6,
) -> Object:
    """A haptic object that stands still."""
    body = _rigid_body(scene, obj, shape)
    body.type = "PASSIVE"
    body.friction = friction
    body.restitution = 0.2
    return tag(scene, obj, substance)


def give_mass(scene: Scene, obj: Object, mass: float, shape: str = "CONVEX_HULL") -> Object:
    """Make an object that follows its animation, or that of its parent, a rigid body. ``mass`` in
    kg counts for the energy of its impacts."""
    body = _rigid_body(scene, obj, shape)
    body.type = "PASSIVE"
    body.kinematic = True
    body.mass = mass
    body.friction = 0.6
    return obj


def make_moving(
    scene: Scene, obj: Object, substance: Substance, mass: float, shape: str = "CONVEX_HULL"
) -> Object:
    """A haptic object with a mass, see `give_mass`."""
    return tag(scene, give_mass(scene, obj, mass, shape), substance)


def make_dynamic(
    scene: Scene,
    obj: Object,
    substance: Substance,
    mass: float,
    shape: str = "BOX",
    friction: float = 0.6,
    restitution: float = 0.2,
) -> Object:
    """A haptic object that falls and collides."""
    body = _rigid_body(scene, obj, shape)
    body.type = "ACTIVE"
    body.mass = mass
    body.friction = friction
    body.restitution = restitution
    return tag(scene, obj, substance)


def make_medium(obj: Object, alpha: float) -> Object:
    """A volume, drawn as wires, that touches what it overlaps and fades signals by ``alpha`` per
    metre."""
    obj.display_type = "WIRE"
    obj.hide_render = True
    obj.visible_shadow = False
    haptics = obj.haptics
    haptics.function, haptics.alpha = "exponential", alpha
    haptics.enabled = haptics.medium = True
    return obj


def spread_as_front(medium: Object, radius: float, speed: float) -> Object:
    """Make a medium transmit a blast with the gain ``radius`` / (``radius`` + distance) [m] at
    ``speed`` [m/s]."""
    spread_all_around(medium.haptics, radius)
    medium.haptics.wave_speed = speed
    return medium


def make_blast(obj: Object, frame: int, seconds: float) -> Object:
    """A source that plays once, at ``frame``: the pressure of a blast whose overpressure lasts so
    many ``seconds``."""
    source = make_source(obj, "BLAST").haptics.source
    source.decay, source.one_shot = seconds, True
    animate(obj, "haptics.source.trigger", {float(frame): 1.0}, CONSTANT)
    return obj


def make_source(
    obj: Object, signal: str, frequency: float = 60.0, amplitude: float = 1.0
) -> Object:
    """A persistent source at the origin of ``obj``: signal is ``SINE``, ``PULSE`` or ``NOISE``,
    frequency in Hz, amplitude in [0, 1]."""
    source = obj.haptics.source
    source.enabled = True
    source.signal = signal
    source.frequency = frequency
    source.amplitude = amplitude
    return obj


def add_texture(
    scene: Scene, kind: str, first: str, second: str, like: str, **values: float
) -> None:
    """A rule for what slides or rolls: objects or materials (``kind``) ``first`` and ``second``
    have the texture of the library's material ``like``, but for ``values``."""
    row = scene.haptics.textures.items.add()
    row.first_kind = row.second_kind = kind
    row.first, row.second = first, second
    for name, value in {**texture_in(like), **values}.items():
        setattr(row, name, value)


def make_listener(obj: Object, body_part: str, gain: float = 1.0) -> Object:
    """A listener at the origin of ``obj``, a point, which represents a body part; ``gain``: that of
    the listener."""
    listener = obj.haptics.listener
    listener.enabled = True
    listener.limiter = False  # the paper clips the mix at the ceiling
    listener.body_part = body_part
    listener.radius = 0.0
    listener.gain = gain
    return obj
