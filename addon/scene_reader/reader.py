"""Reads a Blender scene into the values of the core: the only place that reads haptic properties and transforms.

What an author changes is read when it changes; what moves is read at every frame, all matrices in one call. No bpy object is kept between
calls: only session ids, row numbers and plain values.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from typing import Any

import bpy
import numpy as np
from bpy.app.translations import pgettext_iface as iface_
from bpy.types import Depsgraph, Object, Scene
from mathutils import Matrix
from numpy.typing import NDArray

from ...core.arrays import FloatArray, IntArray
from ...core.contacts.authored import AuthoredContacts
from ...core.contacts.tracker import Body, ContactSettings, Motion
from ...core.scene.functions import ModulationFunction, Spectrum, function_from_dict
from ...core.scene.materials import named_in
from ...core.scene.values import HapticObject, Listener, Pose, Settings, Source, SourceKind
from ...core.signals import (
    DEFAULT_IMPACT,
    DEFAULT_PERSISTENT,
    Automation,
    Decay,
    Loop,
    Noise,
    Pulse,
    Signal,
    Sine,
    impact_material,
    read_wav,
)
from ...core.signals.limits import MIN_SECONDS
from ..blender import compatibility
from ..blender.progress import progress
from ..blender.single_precision import shortest
from ..properties.function import PARAMETERS
from .animated_frequency import AnimatedFrequencies
from .collision_shapes import collision_shape
from .imported import KeptScene, exact, kept_listener, kept_object, kept_scene, kept_source, near
from .imported_contacts import Homes, ImportedContacts

_STEADY = frozenset(
    (
        "ARRAY",
        "BEVEL",
        "DECIMATE",
        "EDGE_SPLIT",
        "MIRROR",
        "MULTIRES",
        "NORMAL_EDIT",
        "REMESH",
        "SCREW",
        "SKIN",
        "SMOOTH",
        "SOLIDIFY",
        "SUBSURF",
        "TRIANGULATE",
        "UV_PROJECT",
        "UV_WARP",
        "WEIGHTED_NORMAL",
        "WELD",
        "WIREFRAME",
    )
)
"""Modifiers that make the same of a mesh in every frame unless they are animated."""

_TREMBLE = np.float32(1e-6)
"""Change of the numbers of a matrix that is none."""


@dataclass(frozen=True, slots=True)
class Problem:
    """Something a designer should mend: the object's name ("" for the scene) and what to do, in the words of the panel."""

    object: str
    message: str


@dataclass(frozen=True, slots=True)
class Reading:
    """One frame of a scene. ``transforms`` (n, 4, 4) of ``objects`` are rigid: the scale is in the bodies' shapes. ``settled``: the names
    of those that stand where an imported file put them; ``authored``: that file's contacts, None where there are none."""

    objects: tuple[HapticObject, ...]
    bodies: tuple[Body, ...]
    transforms: FloatArray
    sources: tuple[Source, ...]
    listeners: tuple[Listener, ...]
    settings: Settings
    contact_settings: ContactSettings
    impact_materials: Mapping[str, str]  # what an object feels like when it is hit, where its material says it
    problems: tuple[Problem, ...]
    settled: frozenset[str] = frozenset()
    authored: AuthoredContacts | None = None

    def posed_objects(self) -> tuple[HapticObject, ...]:
        """The objects with the shape and pose that they have in this frame."""
        return tuple(
            replace(item, shape=body.shape, pose=pose_of(transform))
            for item, body, transform in zip(self.objects, self.bodies, self.transforms, strict=True)
        )


@dataclass(frozen=True, slots=True)
class _Tagged:
    """One tagged object of the scene, as authored."""

    row: int  # in bpy.data.objects
    animated: tuple[str, ...] | None  # data paths, see `compatibility.animated_paths`
    deforming: bool
    scale: tuple[float, float, float]
    object: HapticObject | None
    body: Body | None
    home: Pose | None  # where a file put the body, as it is since
    source: Source | None
    listener: Listener | None
    impact_material: str | None
    problems: tuple[Problem, ...]


@dataclass(frozen=True, slots=True)
class _Lists:
    """What is tagged, in the order of the rows: ``rows`` (m,) in the file and ``scales`` (m, 3) as authored; which of them are bodies, and
    the rows in the file where sources and listeners are."""

    rows: IntArray
    scales: FloatArray
    animated: tuple[tuple[int, tuple[str, ...] | None], ...]  # rows and data paths
    deforming: bool  # any of them
    of_bodies: IntArray
    of_places: IntArray
    objects: tuple[HapticObject, ...]
    bodies: tuple[Body, ...]
    places: tuple[Source | Listener, ...]
    homes: Homes
    impact_materials: Mapping[str, str]
    problems: tuple[Problem, ...]

    @classmethod
    def of(cls, by_row: dict[int, _Tagged], before: _Lists | None = None) -> _Lists:
        """What says the same as ``before`` is the same value, so that nothing that was made of it is made again."""
        tagged = sorted(by_row.values(), key=lambda t: t.row)
        bodies = [(k, t.object, t.body) for k, t in enumerate(tagged) if t.object is not None and t.body is not None]
        sound = {item.name for _, item, _ in bodies}  # what stands on an object that has a problem, or is not shown, is left out with it
        places = [(t.row, item) for t in tagged for item in (t.source, t.listener) if item is not None and item.object in sound]
        objects, alone = tuple(item for _, item, _ in bodies), tuple(body for _, _, body in bodies)
        names, poses = tuple(item.name for item in objects), tuple(tagged[k].home for k, _, _ in bodies)
        if before is not None:
            objects = before.objects if objects == before.objects else objects
            alone = before.bodies if alone == before.bodies else alone
        homed = before is not None and (names, poses) == (before.homes.names, before.homes.poses)
        return cls(
            rows=np.array([t.row for t in tagged], dtype=np.int64),
            scales=np.array([t.scale for t in tagged], dtype=np.float64).reshape(-1, 3),
            animated=tuple((t.row, t.animated) for t in tagged if t.animated != ()),
            deforming=any(t.deforming for t in tagged),
            of_bodies=np.array([k for k, _, _ in bodies], dtype=np.int64),
            of_places=np.array([row for row, _ in places], dtype=np.int64),
            objects=objects,
            bodies=alone,
            places=tuple(item for _, item in places),
            homes=before.homes if before is not None and homed else Homes.of(names, poses),
            impact_materials={t.object.name: t.impact_material for t in tagged if t.object is not None and t.impact_material is not None},
            problems=tuple(problem for t in tagged for problem in t.problems),
        )


class SceneReader:
    """Reads one scene, again and again."""

    def __init__(self) -> None:
        self._session_ids: NDArray[np.int32] | None = None
        self._tagged: dict[int, _Tagged] = {}  # by row
        self._shapes: dict[int, tuple[Any, Any]] = {}  # by session id: what it was built from, and the shape
        self._frequencies = AnimatedFrequencies()
        self._animated: dict[int, tuple[Any, ...]] = {}  # by row: what its animated properties were last
        self._lists: _Lists | None = None
        self._raw = np.zeros((0, 16), dtype=np.float32)  # matrices of the tagged rows as they were read last
        self._rigid = np.zeros((0, 4, 4))  # of the tagged rows
        self._transforms = np.zeros((0, 4, 4))  # of the bodies
        self._placed: list[Source | Listener] = []
        self._settled: frozenset[str] = frozenset()
        self._imported = ImportedContacts()

    def forget(self) -> None:
        """Something an author can change has changed: read everything at the next call."""
        self._session_ids = None

    def forget_shapes(self) -> None:
        """Meshes have changed."""
        self._shapes.clear()
        self._session_ids = None

    @property
    def is_empty(self) -> bool:
        """True where the last reading found nothing tagged, and nothing has changed since."""
        return self._session_ids is not None and not self._tagged

    def read(self, scene: Scene, depsgraph: Depsgraph) -> Reading:
        """The scene as it stands in ``depsgraph``."""
        session_ids = _session_ids()
        raw = _raw_matrices(len(session_ids))
        if self._session_ids is None or not np.array_equal(self._session_ids, session_ids):
            self._read_all(depsgraph, raw)
            self._imported.read(scene)
            self._session_ids = session_ids
        lists = self._read_changed(depsgraph, raw)
        now, duration = seconds_of(scene, scene.frame_current), scene.render.fps_base / scene.render.fps
        heard = [item for item in self._placed if _sounds(item, now, duration)]
        contact_settings = read_contact_settings(scene)
        return Reading(
            objects=lists.objects,
            bodies=lists.bodies,
            transforms=self._transforms,
            sources=tuple(item for item in heard if isinstance(item, Source)),
            listeners=tuple(item for item in heard if isinstance(item, Listener)),
            settings=read_settings(scene),
            contact_settings=contact_settings,
            impact_materials=lists.impact_materials,
            problems=tuple(Problem("", problem) for problem in self._imported.problems) + lists.problems,
            settled=self._settled,
            authored=self._imported.authored(lists.homes, self._settled, contact_settings),
        )

    def _read_all(self, depsgraph: Depsgraph, raw: NDArray[np.float32]) -> None:
        shown = {obj.session_uid for obj in depsgraph.view_layer.objects}
        tagged = {row: obj for row, obj in enumerate(bpy.data.objects) if obj.session_uid in shown and is_tagged(obj)}
        self._frequencies.clear()
        self._animated.clear()
        scales = dict(zip(tagged, rigid_transforms(raw[np.array(list(tagged), dtype=np.int64)])[1], strict=True))
        self._tagged = {row: self._read_object(row, obj, depsgraph, scales[row]) for row, obj in progress(tuple(tagged.items()))}
        self._lists = None

    def _read_changed(self, depsgraph: Depsgraph, raw: NDArray[np.float32]) -> _Lists:
        """Read again what is animated, what was scaled and whose mesh changed, and where everything is now."""
        lists = self._lists or _Lists.of(self._tagged)
        raw_tagged = raw.take(lists.rows, axis=0)
        animated = {row for row, paths in lists.animated if self._is_animated_now(row, paths)}
        if lists is not self._lists:
            rows, moved = set(), np.arange(len(lists.rows))  # everything has just been read
        else:
            # Where simulations at rest tremble, the matrix of before stays.
            rows, moved = animated, np.flatnonzero(~(np.abs(raw_tagged - self._raw) <= _TREMBLE).all(axis=1))
        if len(moved) == len(lists.rows):
            self._raw = raw_tagged
            self._rigid, scales = rigid_transforms(raw_tagged)
        elif len(moved):
            self._raw[moved] = raw_tagged[moved]
            self._rigid = self._rigid.copy()  # the old one belongs to the last reading
            self._rigid[moved], scales = rigid_transforms(raw_tagged[moved])
        if len(moved):
            known = lists.scales[moved]
            rows |= set(lists.rows[moved[np.any(np.abs(scales - known) > 1e-5 * np.abs(known), axis=1)]].tolist())
        if lists.deforming or depsgraph.id_type_updated("MESH"):
            deformed = {u.id.original.session_uid for u in depsgraph.updates if u.is_updated_geometry and isinstance(u.id, Object)}
            for session_id in deformed:
                self._shapes.pop(session_id, None)
            rows |= {row for row in self._tagged if self._session_ids is not None and int(self._session_ids[row]) in deformed}
        changed = False
        again = sorted(rows)
        scales = rigid_transforms(raw[np.array(again, dtype=np.int64)])[1] if again else ()
        for row, scale in zip(again, scales, strict=True):
            tagged = self._read_object(row, bpy.data.objects[row], depsgraph, scale)
            if tagged != self._tagged[row]:
                self._tagged[row] = tagged
                changed = True
        if changed:
            lists = _Lists.of(self._tagged, lists)  # of the same rows
        if len(moved) or lists is not self._lists:
            self._transforms = self._rigid[lists.of_bodies]
            self._transforms.setflags(write=False)  # so that the tracker knows it again
            self._settled = lists.homes.settled(self._transforms)
            self._placed = [
                item if near(item.position, place) else item.moved(place)
                for place, item in zip(raw[lists.of_places, 12:15].tolist(), lists.places, strict=True)
            ]
        self._lists = lists
        return lists

    def _read_object(self, row: int, obj: Object, depsgraph: Depsgraph, scale: FloatArray) -> _Tagged:
        haptics = obj.haptics
        name = obj.name_full
        problems: list[Problem] = []
        haptic_object = body = home = source = listener = None
        scale = self._scale(row, scale)
        if haptics.enabled:
            try:
                shape = self._shape(obj, depsgraph, scale)
                haptic_object = read_object(obj)
                body = Body(name=name, shape=shape, mass=haptic_object.mass, motion=_motion(obj), medium=haptics.medium)
                home = kept_object(haptics.imported).pose if _is_as_imported(obj, scale) else None
            except ValueError as error:
                problems.append(Problem(name, str(error)))
        carrier = haptic_carrier(obj)
        for role in ("source", "listener"):
            if not getattr(haptics, role).enabled:
                continue
            if carrier is None:
                problems.append(Problem(name, _without_carrier(role)))
            elif carrier == obj and haptic_object is None:
                continue  # the object's own problem says it
            else:
                try:
                    if role == "listener":
                        listener = read_listener(obj, carrier.name_full)
                    else:
                        source = read_source(obj, carrier.name_full, self._frequencies.automation(obj, depsgraph.scene))
                except (OSError, ValueError) as error:
                    problems.append(Problem(name, str(error).replace("mixing_expression", "the mixing formula")))
        animated = compatibility.animated_paths(obj)
        deforming = any(animated != () or modifier.type not in _STEADY for modifier in obj.modifiers)
        struck = read_impact_material(obj)
        return _Tagged(
            row, animated, deforming, tuple(scale.tolist()), haptic_object, body, home, source, listener, struck, tuple(problems)
        )

    def _is_animated_now(self, row: int, paths: tuple[str, ...] | None) -> bool:
        """Whether animation has changed any property of the object since it was asked last."""
        if paths is None:
            return True
        values = _values_at(bpy.data.objects[row], paths)
        before, self._animated[row] = self._animated.get(row), values
        return values != before

    def _scale(self, row: int, scale: FloatArray) -> FloatArray:
        """The object's scale in the world; the known one where only rounding differs, so that what turns keeps its shape."""
        known = np.array(self._tagged[row].scale) if row in self._tagged else scale
        return known if np.all(np.abs(scale - known) <= 1e-5 * np.abs(known)) else scale

    def _shape(self, obj: Object, depsgraph: Depsgraph, scale: FloatArray) -> Any:
        body = obj.rigid_body
        settings = () if body is None else (body.collision_shape, body.mesh_source, body.use_margin, body.collision_margin)
        if _is_as_imported(obj, scale):
            kept = kept_object(obj.haptics.imported).shape
            if kept is not None:
                return kept
        key = (tuple(scale.tolist()), settings)
        known = self._shapes.get(obj.session_uid)
        if known is None or known[0] != key:
            known = (key, collision_shape(obj, depsgraph, scale))
            self._shapes[obj.session_uid] = known
        return known[1]


def _values_at(obj: Object, paths: tuple[str, ...]) -> tuple[Any, ...]:
    """The values at data paths of an object, None at one that leads nowhere."""
    values = []
    for path in paths:
        try:
            value = obj.path_resolve(path)
        except ValueError:
            value = None
        values.append(tuple(value) if hasattr(value, "__iter__") else value)
    return tuple(values)


def _is_as_imported(obj: Object, scale: FloatArray) -> bool:
    """False where what an author did since comes before the shape and the pose that a file gave an object."""
    return obj.rigid_body is None and all(abs(side - 1) < 2e-5 for side in scale.tolist())


def is_tagged(obj: Object) -> bool:
    """True where the object has any haptic role."""
    haptics = obj.haptics
    return haptics.enabled or haptics.source.enabled or haptics.listener.enabled


def _without_carrier(role: str) -> str:
    """What to do about a source or listener that is on no haptic object."""
    if role == "source":
        return iface_("This source is on no haptic object: make it haptic, or parent it to a haptic object")
    return iface_("This listener is on no haptic object: make it haptic, or parent it to a haptic object")


def haptic_carrier(obj: Object | None) -> Object | None:
    """The object itself if it is haptic, else its nearest haptic ancestor, else None; for an armature the haptic body that it moves."""
    while obj is not None and not obj.haptics.enabled:
        body = obj.haptics.body
        obj = body if body is not None and body.haptics.enabled else obj.parent
    return obj


def read_function(haptics: Any) -> ModulationFunction:
    """The propagation function of an object: the imported one as long as the properties say the same as far as they can. Raises ValueError
    in words."""
    function, kept = function_of_properties(haptics), kept_object(haptics.imported).function
    return kept if kept is not None and stands_for(function, kept) else function


def stands_for(function: ModulationFunction, imported: ModulationFunction) -> bool:
    """Whether properties that make ``function`` were set to ``imported``: they are rounded and have no gains of bands."""
    numbers = {f.name: getattr(imported, f.name) for f in fields(imported) if f.init}
    floats = {name: shortest(value) for name, value in numbers.items() if isinstance(value, float)}
    wave_speed, decays = imported.spectrum.wave_speed, imported.spectrum.band_decays
    spectrum = Spectrum(wave_speed=shortest(wave_speed), band_decays=tuple(map(shortest, decays)))
    try:
        return replace(imported, **floats, spectrum=spectrum) == function
    except ValueError:  # too small for single precision
        return False


def function_of_properties(haptics: Any) -> ModulationFunction:
    """The propagation function that an object's properties make. Raises ValueError in words."""
    parameters = {key: _typed(getattr(haptics, name)) for key, name in PARAMETERS.get(haptics.function, {}).items()}
    if haptics.wave_speed > 0:
        parameters["wave_speed"] = shortest(haptics.wave_speed)
    if haptics.material.use_bands:
        parameters["band_decays"] = tuple(map(shortest, haptics.material.band_decays))
    return function_from_dict({"function": haptics.function, **parameters})


def _typed(value: Any) -> Any:
    return shortest(value) if isinstance(value, float) else value


def read_object(obj: Object) -> HapticObject:
    """The haptic object of a Blender object. Raises ValueError in words where its function is wrong."""
    haptics = obj.haptics
    numbers = kept_object(haptics.imported).numbers
    return HapticObject(
        name=obj.name_full,
        kappa=exact(haptics, "kappa", numbers),
        rho=exact(haptics, "rho", numbers),
        propagation=read_function(haptics),
        mass=shortest(obj.rigid_body.mass) if obj.rigid_body is not None else kept_object(haptics.imported).mass,
        medium=haptics.medium,
    )


def read_source(obj: Object, carrier: str, frequency: Automation | None = None) -> Source:
    """The source of a Blender object that stands on the haptic object ``carrier``; its position, here where a file put it, is filled in
    per frame. ``frequency``: over the scene's time, where it is animated."""
    properties = obj.haptics.source
    kept = kept_source(properties.imported)
    second = bpy.data.objects.get(kept.second_object or "")
    struck = second is not None and second.haptics.enabled and second.name_full != carrier
    signal = kept.signal if properties.signal == "KEPT" else read_signal(properties, frequency)
    return Source(
        name=obj.name_full,
        object=carrier,
        position=kept.position or (0.0, 0.0, 0.0),
        amplitude=0.0 if properties.muted else exact(properties, "amplitude", kept.numbers),
        kind=kept.kind,
        signal=_wearing_off(signal, properties.decay) if kept.kind is SourceKind.PERSISTENT else signal,
        second_object=kept.second_object if struck else None,
        second_position=kept.second_position if struck else None,
        onset=kept.onset,
        priority=exact(properties, "priority", kept.numbers),
    )


def _wearing_off(signal: Signal | None, seconds: float) -> Signal | None:
    """A persistent source's signal that falls to 1/e in ``seconds``; as it is where these are 0."""
    return (signal or DEFAULT_PERSISTENT) * Decay(shortest(seconds)) if seconds >= MIN_SECONDS else signal


def read_signal(properties: Any, frequency: Automation | None = None) -> Signal:
    """The signal of a source's properties, at an animated ``frequency`` where there is one. Raises ValueError in words where its file
    can't be read."""
    hertz = shortest(properties.frequency) if frequency is None else frequency
    match properties.signal:
        case "SINE":
            return Sine(hertz)
        case "PULSE":
            return Pulse(hertz)
        case "NOISE":
            return Noise()
    if not properties.filepath:
        raise ValueError(iface_("its signal is a WAV file, but none is chosen"))
    return Loop(read_wav(bpy.path.abspath(properties.filepath)))


def read_listener(obj: Object, carrier: str) -> Listener:
    """The listener of a Blender object that stands on the haptic object ``carrier``; its position as that of a source."""
    properties = obj.haptics.listener
    kept = kept_listener(properties.imported)
    return Listener(
        name=obj.name_full,
        object=carrier,
        position=kept.position or (0.0, 0.0, 0.0),
        body_part="" if properties.body_part == "NONE" else properties.body_part,
        radius=exact(properties, "radius", kept.numbers),
        gain=exact(properties, "gain", kept.numbers),
        mixing=properties.mixing,
        s_max=exact(properties, "s_max", kept.numbers),
        mixing_expression=properties.mixing_expression if properties.mixing == "custom" else "",
        limiter=properties.limiter,
    )


def read_impact_material(obj: Object) -> str | None:
    """What an object feels like when it is hit, by the name of its haptic material; None where it has none that is known."""
    material = named_in(obj.haptics.material.name)
    return None if material is None else impact_material(material.name)


def read_settings(scene: Scene) -> Settings:
    """The propagation settings of a scene."""
    haptics = scene.haptics
    try:
        kept = kept_scene(haptics.imported)
    except ValueError:  # the reader says it
        kept = KeptScene()
    return Settings(
        mode=haptics.mode,
        strategy=haptics.strategy,
        max_connections=haptics.max_connections or None,
        threshold=exact(haptics, "threshold", kept.numbers),
        epsilon=exact(haptics, "epsilon", kept.numbers),
        localise=exact(haptics, "localise", kept.numbers),
        **({} if kept.tolerance is None else {"tolerance": kept.tolerance}),
    )


def read_contact_settings(scene: Scene) -> ContactSettings:
    """What counts as a contact and as an impact in a scene."""
    haptics = scene.haptics
    return ContactSettings(
        tolerance=shortest(haptics.contact_tolerance),
        least_energy=shortest(haptics.minimum_energy),
        full_energy=max(shortest(haptics.maximum_energy), 1e-3),
        energy=haptics.impact_energy,
        refractory=shortest(haptics.refractory_time),
        patch_points=haptics.patch_points,
        gravity=tuple(scene.gravity) if scene.use_gravity else (0.0, 0.0, 0.0),
        time_scale=max(scene.rigidbody_world.time_scale, 1e-3) if scene.rigidbody_world is not None else 1.0,
    )


def seconds_of(scene: Scene, frame: float) -> float:
    """Time of a frame in seconds from the scene's first frame."""
    return (frame - scene.frame_start) * scene.render.fps_base / scene.render.fps


def _sounds(item: Source | Listener, now: float, duration: float) -> bool:
    """False for a temporary source that is not heard in the frame of ``duration`` seconds that ends ``now``."""
    if not isinstance(item, Source) or item.kind is SourceKind.PERSISTENT:
        return True
    return item.onset <= now < item.onset + (item.signal or DEFAULT_IMPACT).duration + duration


def _motion(obj: Object) -> Motion:
    body = obj.rigid_body
    if body is None or body.kinematic:
        return Motion.KINEMATIC
    return Motion.DYNAMIC if body.type == "ACTIVE" else Motion.STATIC


def _session_ids() -> NDArray[np.int32]:
    ids = np.empty(len(bpy.data.objects), dtype=np.int32)
    bpy.data.objects.foreach_get("session_uid", ids)
    return ids


def _raw_matrices(count: int) -> NDArray[np.float32]:
    """(n, 16) world matrices of all objects of the file, column by column."""
    values = np.empty(16 * count, dtype=np.float32)
    bpy.data.objects.foreach_get("matrix_world", values)
    return values.reshape(count, 16)


def pose_of(transform: FloatArray) -> Pose:
    """The pose of a rigid transform (4, 4)."""
    rotation = Matrix(transform[:3, :3].tolist()).to_quaternion()
    return Pose(tuple(transform[:3, 3].tolist()), (rotation.w, rotation.x, rotation.y, rotation.z))


def rigid_transforms(raw: NDArray[np.float32]) -> tuple[FloatArray, FloatArray]:
    """Split raw matrices (n, 16) into rigid transforms (n, 4, 4) and scales (n, 3), negative where mirrored.

    A shear is dropped, as Bullet does.
    """
    columns = raw.T.astype(np.float64, order="C").reshape(4, 4, -1)
    axes = columns[:3, :3]
    scales = np.sqrt((axes * axes).sum(axis=1))
    x, y, z = axes
    volume = (y[1] * z[2] - y[2] * z[1]) * x[0] + (y[2] * z[0] - y[0] * z[2]) * x[1] + (y[0] * z[1] - y[1] * z[0]) * x[2]
    scales[:, volume < 0] *= -1
    axes /= np.where(scales == 0, 1.0, scales)[:, None]
    return columns.transpose(2, 1, 0).copy(), scales.T
