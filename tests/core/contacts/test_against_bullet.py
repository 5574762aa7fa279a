"""Distances, points and contacts of random pairs of shapes against Bullet: a record of it, and
PyBullet itself where it is installed."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path

import numpy as np
import pytest
from haptic_tracing.core.contacts.narrow.frames import relative_pose
from haptic_tracing.core.contacts.narrow.manifold import ROUGHNESS
from haptic_tracing.core.contacts.narrow.narrow_phase import NarrowPhase
from haptic_tracing.core.contacts.settings import Body, ContactSettings
from haptic_tracing.core.contacts.shapes import Box, Compound
from haptic_tracing.core.contacts.tracker import ContactTracker

sys.path.insert(0, str(Path(__file__).parent))
import bullet_pairs

TOLERANCE = 0.01
BAND = 0.001


def poses_12(matrices: np.ndarray) -> np.ndarray:
    return np.concatenate([matrices[:, :3, :3].reshape(-1, 9).T, matrices[:, :3, 3].T])


def compared(answers, name_a: str, name_b: str) -> dict[str, np.ndarray]:
    """Errors of our answers about one pair of shapes [m], and whether contact is decided
    differently."""
    key = f"{name_a} {name_b}"
    matrices = bullet_pairs.matrices(answers[f"{key} poses"])
    count = len(matrices)
    narrow = NarrowPhase([bullet_pairs.SHAPES[name_a], bullet_pairs.SHAPES[name_b]])
    placed = relative_pose(poses_12(matrices[:, 0]), poses_12(matrices[:, 1]))
    found = narrow.query(
        np.tile([[0, 1]], (count, 1)), *placed, np.full(count, 2 * bullet_pairs.REACH)
    )
    turn = matrices[:, 0, :3, :3]
    centre = np.einsum("nij,jn->ni", turn, found.centre) + matrices[:, 0, :3, 3]
    normal = np.einsum("nij,jn->ni", turn, found.normal)
    theirs = answers[f"{key} distance"]
    away = answers[f"{key} points"] - centre[:, None]
    nearest = np.nanargmin(np.linalg.norm(away, axis=2), axis=1)
    away = away[np.arange(count), nearest]
    beyond = np.zeros(count)
    for name, placed in ((name_a, matrices[:, 0]), (name_b, matrices[:, 1])):
        if isinstance(box := bullet_pairs.SHAPES[name], Box):
            seen = np.einsum("nji,nj->ni", placed[:, :3, :3], centre - placed[:, :3, 3])
            outside = np.maximum(np.abs(seen) - np.array(box.size) / 2, 0.0)
            away_from = np.linalg.norm(outside, axis=1) - np.abs(found.distance) / 2
            beyond = np.maximum(beyond, away_from)
    return {
        "beyond": beyond,
        "distance": np.abs(found.distance - theirs),
        "point": np.linalg.norm(away, axis=1),
        "height": np.abs((away * normal).sum(axis=1)),
        "decision": ((found.distance <= TOLERANCE) != (theirs <= TOLERANCE))
        & (np.abs(theirs - TOLERANCE) > BAND),
    }


def table(answers) -> str:
    """Agreement per pair of shapes, one line each."""
    lines = [f"{'shapes':20s} {'pairs':>5s} {'contact':>8s}  distance [mm]        point [mm]"]
    lines.append(
        f"{'':20s} {'':5s} {'differs':>8s}  {'median':>8s} {'greatest':>9s}  {'median':>8s} "
        f"{'95 %':>8s} {'<= 3 mm':>8s}"
    )
    for name_a, name_b in bullet_pairs.PAIRS:
        found = compared(answers, name_a, name_b)
        distance, point = found["distance"] * 1e3, found["point"] * 1e3
        lines.append(
            f"{name_a + ' ' + name_b:20s} {len(point):5d} {found['decision'].sum():8d}  "
            f"{np.median(distance):8.3f} {distance.max():9.3f}"
            f"  {np.median(point):8.3f} {np.quantile(point, 0.95):8.3f} {(point <= 3).mean():8.1%}"
        )
    return "\n".join(lines)


def check(answers, share: float, origin: str = "recorded") -> None:
    """``share`` of the points must be within 3 mm. Of two parallel edges or faces, and of two
    places that are as near to a tenth of a millimetre, Bullet names any: there the middle of all of
    them is elsewhere, though as near. The patch of two boxes, or of the parts of a compound, is the
    middle of all that is nearly as near, and so within ``ROUGHNESS`` of both."""
    for name_a, name_b in bullet_pairs.PAIRS:
        found = compared(answers, name_a, name_b)
        where = f"{name_a} {name_b}, {origin}"
        assert not found["decision"].any(), where
        assert found["distance"].max() < 2e-3, where
        assert found["beyond"].max() < ROUGHNESS, where
        shapes = [bullet_pairs.SHAPES[name] for name in (name_a, name_b)]
        if all(isinstance(shape, Box) for shape in shapes):
            continue
        assert np.median(found["point"]) < 1e-3, where
        if any(isinstance(shape, Compound) for shape in shapes):
            continue
        assert (found["height"] < 1e-3).mean() >= 0.97, where
        assert (found["point"] < 3e-3).mean() >= share, where


@pytest.mark.slow
def test_recorded_pairs(capsys):
    with np.load(bullet_pairs.RECORDED) as answers:
        with capsys.disabled():
            print("\n" + table(answers))
        check(answers, 0.94)


def check_pile(answers) -> None:
    """The pairs that touch in a pile, frame by frame, by the tracker."""
    bodies = [Body("ground", bullet_pairs.GROUND, motion="static")]
    bodies += [
        Body(f"{name} {k}", bullet_pairs.SHAPES[name], 10.0)
        for k, name in enumerate(bullet_pairs.PILE)
    ]
    tracker = ContactTracker(bodies, ContactSettings(tolerance=TOLERANCE, slack=0.0))
    touching = 0
    for snapshot, matrices in enumerate(bullet_pairs.matrices(answers["pile poses"])):
        found = tracker.update(snapshot / 2, matrices).contacts
        ours = {
            tuple(pair): distance
            for pair, distance in zip(found.pairs.tolist(), found.distance.tolist(), strict=True)
        }
        rows = answers["pile pairs"][answers["pile pairs"][:, 0] == snapshot]
        theirs = {(int(a), int(b)): distance for _, a, b, distance in rows.tolist()}
        for pair, distance in theirs.items():
            if distance <= TOLERANCE - BAND:
                assert pair in ours, (snapshot, pair, distance)
        for pair, distance in ours.items():
            assert pair in theirs and theirs[pair] <= TOLERANCE + BAND, (snapshot, pair, distance)
            assert abs(theirs[pair] - distance) < 2e-3
        touching += len(ours)
    assert touching > 250


@pytest.mark.slow
def test_recorded_pile():
    with np.load(bullet_pairs.RECORDED) as answers:
        check_pile(answers)


@pytest.mark.skipif(
    importlib.util.find_spec("pybullet") is None,
    reason="PyBullet is not installed; its record is checked above",
)
def test_fresh_pairs():
    check_pile(bullet_pairs.pile(seed=2))
    seed = np.random.SeedSequence().entropy
    check(bullet_pairs.asked(seed=seed, count=200), 0.9, f"seed {seed}")
