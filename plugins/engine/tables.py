"""The tables of a tracer: what a program without Python needs to trace a scene by itself.

A tracer keeps the graph of contacts, finds best paths and mixes; all else is computed here: losses
by frequency band, spreading, impedances of bodies, what contacts between classes of objects pass on
and which signals their impacts play, samples of signals. Lengths are in metres, axes those of glTF:
right-handed, y up.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from ...core.arrays import FloatArray
from ...core.contacts.scene_contacts import contacts_of_scene
from ...core.contacts.shapes import pose_matrix
from ...core.contacts.transmissions import TransmissionRules
from ...core.formats.io.json_text import write_compact
from ...core.formats.provenance import provenance_of
from ...core.forms import JsonObject
from ...core.graph.impedances import Bodies
from ...core.graph.object_frames import local_bounds
from ...core.scene.bands import BAND_CENTRES, BAND_COUNT
from ...core.scene.functions import (
    Expression,
    HapticTracing,
    Linear,
    ModulationFunction,
    Physical,
)
from ...core.scene.rules import Motion, full_energy_of
from ...core.scene.spectra import leading_band
from ...core.scene.values import Contact, HapticObject, HapticScene, Pose, Source
from ...core.signals import DEFAULT_IMPACT, Signal, impact_template
from .sampled import sampled

FORMAT, VERSION = "haptic-tracer", 1
RATE = 8000
"""Samples of signals a second."""
MOST_COST = 14.0
"""Cost [Np] beyond that at which a search ends, -120 dB."""
GRID = (0.0, *np.geomspace(1e-3, 1e3, 127).round(9).tolist())
"""Where formulas are sampled: metres, or the unit of another variable."""
_STRENGTHS = (0.0, 0.5, 1.0)
_USUAL = {"area": 0.01, "depth": 0.0, "angle": 0.0, "force": 1.0}


def write(scene: HapticScene, path: Path) -> Path:
    """Write the tables of a scene as JSON in one step."""
    return write_compact(path, tables(scene))


def tables(scene: HapticScene) -> JsonObject:
    """The tables of a scene at rest, as `tracer.schema.json` says. Best paths of mode HT are
    traced, whatever its settings are."""
    return _Tables(scene).document()


class _Tables:
    """The tables of a scene while they are made; what is alike is written once."""

    def __init__(self, scene: HapticScene) -> None:
        self.scene = scene
        self.objects = scene.objects
        self.number = {item.name: k for k, item in enumerate(scene.objects)}
        self.pose = [pose_matrix(item.pose or Pose()) for item in scene.objects]
        self.bodies = Bodies.of(scene.objects)
        self.fixed = _fixed_contacts(scene)
        self.rules = TransmissionRules(
            scene.rules.transmission_table, [(item.name, item.material) for item in scene.objects]
        )
        self.lanes = 1 + BAND_COUNT * self._uses_bands()
        self._functions: dict[str, tuple[int, JsonObject]] = {}
        self._signals: dict[Signal, int] = {}
        self._impacts: dict[str, tuple[int, JsonObject]] = {}

    def document(self) -> JsonObject:
        classes, first = _classes(self.scene, self.rules)
        between = [[(self.objects[a], self.objects[b]) for b in first] for a in first]
        parts = {
            "objects": [self._object(k, classes[k]) for k in range(len(self.objects))],
            "contacts": [self._fixed(contact) for contact in self.fixed],
            "between": [[self._between(a, b) for a, b in row] for row in between],
            "blows": [[self._impact(a, b) for a, b in row] for row in between],
            "sources": [self._source(source) for source in self.scene.sources],
            "listeners": [
                {
                    "name": item.name,
                    "object": self.number[item.object],
                    "position": self._local(item.object, item.position),
                    "radius": item.radius,
                    "gain": item.gain,
                    "s_max": item.s_max,
                    "body_part": item.body_part,
                }
                for item in self.scene.listeners
            ],
        }
        return {
            "format": FORMAT,
            "version": VERSION,
            "provenance": provenance_of(self.scene),
            "sample_rate": RATE,
            "lanes": self.lanes,
            "frequencies": BAND_CENTRES,
            "grid": GRID,
            **parts,
            "functions": [form for _, form in self._functions.values()],
            "impacts": [form for _, form in self._impacts.values()],
            "signals": [self._sampled(signal) for signal in self._signals],
        }

    def _uses_bands(self) -> bool:
        functions = [*self.rules.functions, *(contact.transmission for contact in self.fixed)]
        by_body = any(function.between_bodies for function in functions)
        return (
            any(function.band_gains() or function.spectrum.band_decays for function in functions)
            or any(o.propagation.band_gains() for o in self.objects)
            or any(o.propagation.band_decays(o.kappa, o.rho) for o in self.objects)
            or (by_body and bool(self.bodies.known.any()))
        )

    def _object(self, k: int, its_class: int) -> JsonObject:
        item = self.objects[k]
        function = item.propagation
        decays = function.band_decays(item.kappa, item.rho)
        form: JsonObject = {
            "name": item.name,
            "pose": _pose(item.pose or Pose()),
            "class": its_class,
            "function": self._function(function, item.kappa, item.rho, decays),
            "mass": _moving_mass(item),
        }
        if item.shape is not None:
            low, high = local_bounds([item.shape])[0]
            form["centre"] = _turned((low + high) / 2)
            form["size"] = np.abs(_turned(high - low)).tolist()
        if self.bodies.known[k]:
            form["body"] = self._body(k)
        return form

    def _body(self, k: int) -> JsonObject:
        bodies = self.bodies
        body: JsonObject = {"kind": int(bodies.kind[k]), "impedance": bodies.impedance[k].tolist()}
        if bodies.bending[k].any():
            body["bending"] = bodies.bending[k].tolist()
        if bodies.half_space[0, k]:
            body["half_space"] = bodies.half_space[:, k].tolist()
        if bodies.spring[0, k] < math.inf:
            body["spring"] = bodies.spring[:, k].tolist()
        return body

    def _function(
        self,
        function: ModulationFunction,
        kappa: float,
        rho: float,
        decays: Sequence[float],
        on_contact: bool = False,
    ) -> int:
        """The number of a function for these values of kappa and rho; ``decays``: of bands, [] for
        none."""
        epsilon = self.scene.settings.epsilon
        pair = function.log_linear(kappa, rho, epsilon)
        plain = (0.0, 0.0) if pair is None else (function.loss(kappa, rho, epsilon), pair[1])
        with np.errstate(divide="ignore"):
            gains = -np.log(np.array(function.band_gains() or (1.0,) * BAND_COUNT))
        more = np.array(decays or (0.0,) * BAND_COUNT)
        form: JsonObject = {
            "loss": [_finite(plain[0] + x) for x in (0.0, *gains.tolist())[: self.lanes]],
            "decay": [plain[1] + x for x in (0.0, *more.tolist())[: self.lanes]],
        }
        law = function.spreading_law()
        if law.exponent:
            form["spreading"] = [_finite(value) for value in law]
        if isinstance(function, Linear):
            form["range"] = function.range
        elif pair is None or function.uses_force:
            form["over"], form["costs"] = _sampled_costs(function, kappa, rho, epsilon)
        if function.spectrum.wave_speed:
            form["slowness"] = 1 / function.spectrum.wave_speed
        if on_contact and function.between_bodies is not None:
            form["spring"] = [_finite(value) for value in function.between_bodies]
        return self._kept(self._functions, form)

    def _between(self, one: HapticObject, other: HapticObject) -> int:
        named = [(item.name, item.material) for item in (one, other)]
        function = self.rules.table.of(*named) or self.rules.functions[0]
        return self._across(function, one, other)

    def _across(self, function: ModulationFunction, one: HapticObject, other: HapticObject) -> int:
        """The number of a function of contacts of two objects."""
        kappa, rho = (one.kappa + other.kappa) / 2, (one.rho + other.rho) / 2
        return self._function(function, kappa, rho, function.spectrum.band_decays, True)

    def _fixed(self, contact: Contact) -> JsonObject:
        a, b = (self.number[name] for name in contact.objects)
        return {
            "objects": [a, b],
            "positions": [
                self._local(name, place)
                for name, place in zip(contact.objects, contact.positions, strict=True)
            ],
            "normal": _turned(self.pose[a][:3, :3].T @ contact.normal),
            "area": contact.area,
            "depth": max(contact.depth, 0.0),
            "weight": contact.weight,
            "function": self._across(contact.transmission, self.objects[a], self.objects[b]),
        }

    def _impact(self, one: HapticObject, other: HapticObject) -> int | None:
        """The number, in `impacts`, of that of two objects; None if they play nothing."""
        rules = self.scene.rules
        if not rules.impacts or one.medium or other.medium:
            return None
        named = [(item.name, item.material) for item in (one, other)]
        rule = replace(rules.impact_rule(*named), variation=0.0)
        limits = rules.impact_limits(*named)
        full = limits.full_energy or full_energy_of(map(_moving_mass, self.objects))
        template = rule.template
        if not isinstance(template, Signal):
            both = one.impact_material, other.impact_material
            known = template == "by_material" and all(both)
            template = impact_template(*both) if known else DEFAULT_IMPACT
        played = [
            rule.played(template, strength, (one.name, other.name), 0.0)[0]
            for strength in _STRENGTHS
        ]
        signals = [self._signal(signal) for signal in played]
        return self._kept(
            self._impacts,
            {
                "least_energy": limits.least_energy or 0.0,
                "full_energy": full,
                "gain": list(rule.gain),
                "signals": signals if len(set(signals)) > 1 else signals[:1],
            },
        )

    def _source(self, source: Source) -> JsonObject:
        return {
            "name": source.name,
            "object": self.number[source.object],
            "position": self._local(source.object, source.position),
            "amplitude": source.amplitude,
            "once": source.triggers is not None,
            "signal": self._signal(source.emitted),
        }

    def _signal(self, signal: Signal) -> int:
        return self._signals.setdefault(signal, len(self._signals))

    def _sampled(self, signal: Signal) -> JsonObject:
        source = Source("signal", "object", signal=signal)
        lane = 1 + leading_band(source) if self.lanes > 1 else 0
        return {"lane": lane, **sampled(signal, RATE, self.lanes)}

    def _local(self, name: str, position: Sequence[float]) -> list[float]:
        """A place in the world in the space of an object."""
        pose = self.pose[self.number[name]]
        return _turned(pose[:3, :3].T @ (np.asarray(position) - pose[:3, 3]))

    @staticmethod
    def _kept(known: dict[str, tuple[int, JsonObject]], form: JsonObject) -> int:
        return known.setdefault(repr(form), (len(known), form))[0]


def _fixed_contacts(scene: HapticScene) -> list[Contact]:
    """The contacts that a scene lists, and those at joints."""
    jointed = {frozenset(joint.objects) for joint in scene.rules.joints}
    found = [
        contact
        for contact in (
            contacts_of_scene(scene).to_contacts([item.name for item in scene.objects])
            if jointed
            else ()
        )
        if frozenset(contact.objects) in jointed
    ]
    return [*scene.contacts, *found]


def _classes(scene: HapticScene, rules: TransmissionRules) -> tuple[list[int], list[int]]:
    """The class of each object, whose contacts and impacts the rules treat alike, and the first
    object of each class."""
    sides = [
        side
        for table in (scene.rules.transmission_table, scene.rules.impact_table)
        for row in table.rows
        for side in row.between
    ]
    asks = any(map(_asks_for_material, rules.functions))
    known: dict[object, int] = {}
    classes, first = [], []
    for number, item in enumerate(scene.objects):
        fits = tuple(side.fits(item.name, item.material) for side in sides)
        key = fits, item.impact_material, item.medium, (item.kappa, item.rho) if asks else None
        if key not in known:
            first.append(number)
        classes.append(known.setdefault(key, len(known)))
    return classes, first


def _asks_for_material(function: ModulationFunction) -> bool:
    """Whether what a contact passes on depends on kappa and rho of its objects."""
    if isinstance(function, Expression):
        return function.compiled.uses("kappa", "rho")
    return isinstance(function, HapticTracing | Physical)


def _sampled_costs(
    function: ModulationFunction, kappa: float, rho: float, epsilon: float
) -> tuple[str, list[float]]:
    """The variable on which a function depends, and its costs over `GRID`."""
    over = "distance"
    if not isinstance(function, Expression):
        over = "force"
    else:
        over = next((name for name in _USUAL if function.compiled.uses(name)), over)
    grid = np.array(GRID)
    values: dict[str, float | FloatArray] = {**_USUAL, over: grid}
    distance = values.pop("distance", np.zeros(len(grid)))
    with np.errstate(divide="ignore"):
        costs = -np.log(function.gain(np.asarray(distance), kappa, rho, epsilon, values))
    return over, np.clip(costs, 0.0, MOST_COST).round(9).tolist()


def _moving_mass(item: HapticObject) -> float:
    """The mass [kg] of what can be moved, else 0."""
    return 0.0 if item.motion is Motion.STATIC or item.medium else item.mass or 0.0


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _turned(vector: FloatArray) -> list[float]:
    """A vector in the axes of glTF."""
    x, y, z = vector.tolist()
    return [x, z, -y]


def _pose(pose: Pose) -> list[float]:
    """Position and rotation (w, x, y, z) in the axes of glTF."""
    w, *axis = pose.rotation
    return [*_turned(np.array(pose.position)), w, *_turned(np.array(axis))]
