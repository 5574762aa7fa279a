"""Pressing forces of resting contacts beside the impulses that Bullet's own contacts have, and
beside statics."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest
from haptic_tracing.core.contacts.contact_set import ContactSet
from haptic_tracing.core.contacts.forces import MOST_BODIES, contact_forces
from haptic_tracing.core.contacts.scene_contacts import contacts_of_scene
from haptic_tracing.core.contacts.shapes import Box, Sphere
from haptic_tracing.core.scene.values import Contact, HapticObject, HapticScene, Pose

EARTH = (0.0, 0.0, -9.81)
SCENES = json.loads(Path(__file__).with_name("bullet_forces.json").read_text(encoding="utf-8"))


def errors(scene: dict) -> np.ndarray:
    """Relative errors of the contacts that carry more than 2 % of a body's weight (the median
    one's); not a number where it is unknown."""
    objects = [
        HapticObject(
            f"{number:03}",
            0.5,
            0.5,
            shape=Box(tuple(2 * h for h in body["half"]))
            if body["shape"] == "box"
            else Sphere(body["half"][0]),
            pose=Pose(tuple(place), (turn[3], *turn[:3])),
        )
        for number, (body, (place, turn)) in enumerate(
            zip(scene["bodies"], scene["poses"], strict=True)
        )
    ]
    mass = np.array([body["mass"] for body in scene["bodies"]], dtype=float)
    contacts = contacts_of_scene(HapticScene(tuple(objects)), tolerance=0.002)
    found = contact_forces(contacts, mass, np.array([place for place, _ in scene["poses"]]), EARTH)
    mine = {
        (min(pair), max(pair)): force
        for pair, force in zip(contacts.pairs.tolist(), found.tolist(), strict=True)
    }
    least = 0.02 * 9.81 * np.median(mass[mass > 0])
    return np.array(
        [abs(mine[a, b] - force) / force for a, b, force in scene["forces"] if force > least]
    )


@pytest.mark.parametrize("kind", ["stack", "slope"])
def test_stacks_and_slopes_within_a_tenth(kind):
    found = np.concatenate([errors(scene) for scene in SCENES if scene["kind"] == kind])
    known = found[~np.isnan(found)]
    assert len(known) == len(found) >= 24
    assert known.max() < 0.1


def test_beams_on_two_supports_within_a_tenth():
    found = np.concatenate([errors(scene) for scene in SCENES if scene["kind"] == "table"])
    assert found.max() < 0.1


@pytest.mark.slow
def test_piles_within_a_quarter_in_the_median():
    """Redundant supports do not determine how they share, and Bullet's share depends on how they
    came to rest."""
    for kind in ("pile", "spheres"):
        found = np.concatenate([errors(scene) for scene in SCENES if scene["kind"] == kind])
        assert len(found) > 200 and not np.isnan(found).any()
        assert np.median(found) < 0.25


def resting(
    count: int, mass: float = 2.0, sideways: float = 0.0
) -> tuple[ContactSet, np.ndarray, np.ndarray]:
    """Bodies on each other on a floor that holds them, each contact an area of 0.01 m^2, its normal
    tilted ``sideways``."""
    names = [f"{k:04}" for k in range(count + 1)]
    normal = (math.sin(sideways), 0.0, math.cos(sideways))
    contacts = [
        Contact((names[k], names[k + 1]), ((0, 0, float(k)),) * 2, area=0.01, normal=normal)
        for k in range(count)
    ]
    index = {name: k for k, name in enumerate(names)}
    centres = np.array([[0, 0, k - 0.5] for k in range(count + 1)])
    return ContactSet.from_contacts(contacts, index), np.array([0.0] + [mass] * count), centres


def test_a_column_carries_what_is_above():
    contacts, mass, centre = resting(4)
    assert contact_forces(contacts, mass, centre, EARTH) == pytest.approx(
        [4 * 19.62, 3 * 19.62, 2 * 19.62, 19.62], rel=1e-4
    )


def test_what_is_not_known_is_not_said():
    contacts, mass, centre = resting(3)
    unknown = mass.copy()
    unknown[2] = math.nan
    assert np.isnan(contact_forces(contacts, unknown, centre, EARTH)).all()
    floating = mass.copy()
    floating[0] = 5.0  # the floor falls, too
    assert np.isnan(contact_forces(contacts, floating, centre, EARTH)).any()
    beside, mass, centre = resting(1, sideways=math.pi / 2)  # pressed by nothing against a wall
    assert np.isnan(contact_forces(beside, mass, centre, EARTH)).all()
    many, mass, centre = resting(MOST_BODIES + 1)
    assert np.isnan(contact_forces(many, mass, centre, EARTH)).all()


def test_without_gravity_nothing_presses():
    contacts, mass, centre = resting(3)
    assert contact_forces(contacts, mass, centre, (0.0, 0.0, 0.0)) == pytest.approx(
        [0.0, 0.0, 0.0], abs=1e-9
    )
