"""The same poses give the same bits, wherever in memory they and everything else happen to lie, and
whatever is computed with them."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest
from haptic_tracing.core.contacts.narrow.frames import relative_pose
from haptic_tracing.core.contacts.narrow.narrow_phase import NarrowPhase
from haptic_tracing.core.contacts.shapes import ConvexHull, Shape

sys.path.insert(0, str(Path(__file__).parent))
import bullet_pairs

SLOW = {"cylinder", "hull", "mesh", "pyramid"}
TYPICAL = {("box", "cylinder"), ("hull", "mesh"), ("pyramid", "hull")}
"""Of the slow pairs, those that represent the others in the suite."""


def _marks(pair: tuple[str, str]) -> list[pytest.MarkDecorator]:
    if not SLOW & set(pair):
        return []
    return [pytest.mark.slow] if pair in TYPICAL else [pytest.mark.slow, pytest.mark.more]


PAIRS = [pytest.param(*pair, marks=_marks(pair)) for pair in bullet_pairs.PAIRS]


def elsewhere(array: np.ndarray, offset: int) -> np.ndarray:
    """A copy that begins so many bytes behind the start of its memory."""
    copy = (
        np.empty(array.nbytes + offset, dtype=np.uint8)[offset:]
        .view(array.dtype)
        .reshape(array.shape)
    )
    copy[...] = array
    return copy


def limb(first: float, second: float, length: float) -> ConvexHull:
    """Hull of two balls of these radii, drawn in rings: many of its points are as far along a
    direction as others."""
    turn = np.linspace(0, 2 * np.pi, 8, endpoint=False)
    up = np.linspace(-np.pi / 2, np.pi / 2, 7)
    ball = np.stack(
        [
            np.outer(np.cos(up), np.cos(turn)),
            np.outer(np.cos(up), np.sin(turn)),
            np.outer(np.sin(up), np.ones(8)),
        ]
    )
    ball = ball.reshape(3, -1).T
    return ConvexHull(np.concatenate([first * ball, second * ball + [0, 0, length]]))


def distinct(shapes: list[Shape], rotation: np.ndarray, offset: np.ndarray, repeats: int) -> int:
    """How many different answers there are to the same question."""
    count, random, kept = offset.shape[1], np.random.default_rng(1), []
    answers = set()
    for repeat in range(repeats):
        where = 8 * (repeat % 8)
        pairs, reach = np.tile([[0, 1]], (count, 1)), np.full(count, 0.1)
        found = NarrowPhase(shapes).query(
            pairs, elsewhere(rotation, where), elsewhere(offset, where), reach
        )
        answers.add(
            b"".join(
                part.tobytes() for part in (found.distance, found.normal, found.centre, found.area)
            )
        )
        kept += [bytearray(int(size)) for size in random.integers(1, 4000, 40)]
        del kept[:: 1 + int(random.integers(2, 5))]
    return len(answers)


def recorded(name_a: str, name_b: str) -> tuple[np.ndarray, np.ndarray]:
    """Rotations and offsets of pairs of bodies, nearer than they were recorded, so that many
    overlap."""
    with np.load(Path(__file__).parent / "bullet_pairs.npz") as answers:
        matrices = bullet_pairs.matrices(answers[f"{name_a} {name_b} poses"][:40])
    poses = [
        np.concatenate([m[:, :3, :3].reshape(-1, 9).T, m[:, :3, 3].T])
        for m in (matrices[:, 0], matrices[:, 1])
    ]
    poses[1][9:] = poses[0][9:] + 0.8 * (poses[1][9:] - poses[0][9:])
    return relative_pose(*poses)


@pytest.mark.parametrize(("name_a", "name_b"), PAIRS)
def test_contacts_do_not_depend_on_places_in_memory(name_a: str, name_b: str) -> None:
    assert (
        distinct(
            [bullet_pairs.SHAPES[name_a], bullet_pairs.SHAPES[name_b]], *recorded(name_a, name_b), 8
        )
        == 1
    )


@pytest.mark.parametrize(("name_a", "name_b"), PAIRS)
def test_contacts_do_not_depend_on_what_is_computed_with_them(name_a: str, name_b: str) -> None:
    """One by one, by twos, by sevens and all together."""
    rotation, offset = recorded(name_a, name_b)
    narrow = NarrowPhase([bullet_pairs.SHAPES[name_a], bullet_pairs.SHAPES[name_b]])

    def found(rows: slice) -> np.ndarray:
        turn, shift = rotation[..., rows].copy(), offset[:, rows].copy()
        answer = narrow.query(
            np.tile([[0, 1]], (shift.shape[1], 1)), turn, shift, np.full(shift.shape[1], 0.1)
        )
        return np.concatenate(
            [answer.distance[None], answer.normal, answer.centre, answer.area[None]]
        )

    together = found(slice(None))
    for size in (1, 2, 7):
        parts = [found(slice(begin, begin + size)) for begin in range(0, offset.shape[1], size)]
        np.testing.assert_array_equal(np.concatenate(parts, axis=1), together)


@pytest.mark.slow
def test_hulls_do_not_depend_on_places_in_memory() -> None:
    angle = 0.1 * np.arange(20)
    one, none = np.ones(20), np.zeros(20)
    rotation = np.array(
        [
            [one, none, none],
            [none, np.cos(angle), -np.sin(angle)],
            [none, np.sin(angle), np.cos(angle)],
        ]
    )
    assert (
        distinct(
            [limb(0.05, 0.06, 0.4), limb(0.07, 0.06, 0.4)],
            rotation,
            np.array([none, none, 0.4 * one]),
            60,
        )
        == 1
    )
