"""Bodies that come to rest in Bullet, and the impulses of its contacts then.

``python bullet_rests.py`` records ``bullet_forces.json`` with PyBullet 3.2.7, for which there are
wheels up to Python 3.11; the tests read that.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

RECORDED = Path(__file__).with_name("bullet_forces.json")
KINDS = {"stack": 4, "slope": 12, "table": 3, "pile": 8, "spheres": 6}
"""Number of scenes of each kind."""
_RATE, _MEAN = 240, 60


class World:
    """A world of PyBullet that is filled and left alone."""

    def __init__(self, bullet) -> None:
        self.bullet, self.bodies = bullet, []
        bullet.resetSimulation()
        bullet.setGravity(0, 0, -9.81)
        bullet.setTimeStep(1 / _RATE)
        bullet.setPhysicsEngineParameter(numSolverIterations=400, solverResidualThreshold=1e-9)
        self.add("box", (10, 10, 0.5), (0, 0, -0.5), 0)

    def add(self, shape, half, place, mass, turn=(0, 0, 0, 1), friction=0.8) -> None:
        p = self.bullet
        form = {"halfExtents": half} if shape == "box" else {"radius": half[0]}
        body = p.createMultiBody(
            mass,
            p.createCollisionShape(p.GEOM_BOX if shape == "box" else p.GEOM_SPHERE, **form),
            -1,
            place,
            turn,
        )
        p.changeDynamics(body, -1, lateralFriction=friction, restitution=0)
        if shape == "sphere":
            p.changeDynamics(body, -1, rollingFriction=0.01, spinningFriction=0.01)
        self.bodies.append({"shape": shape, "half": [float(h) for h in half], "mass": mass})

    def rest(self, seconds: int) -> dict:
        p = self.bullet
        for _ in range(_RATE * seconds):
            p.stepSimulation()
        forces: dict[tuple[int, int], float] = {}
        for _ in range(_MEAN):
            p.stepSimulation()
            for contact in p.getContactPoints():
                pair = min(contact[1:3]), max(contact[1:3])
                forces[pair] = forces.get(pair, 0.0) + contact[9] / _MEAN
        assert all(
            np.linalg.norm(p.getBaseVelocity(body)[0]) < 1e-3 for body in range(len(self.bodies))
        ), "still on the move"
        poses = [
            [list(part) for part in p.getBasePositionAndOrientation(body)]
            for body in range(len(self.bodies))
        ]
        return {
            "bodies": self.bodies,
            "poses": poses,
            "forces": [[a, b, f] for (a, b), f in sorted(forces.items())],
        }


def fill(world: World, kind: str, rng: np.random.Generator) -> None:
    """Put what the kind of scene is made of into the world."""
    if kind == "stack":
        z = 0.0
        for _ in range(int(rng.integers(3, 9))):
            half = rng.uniform(0.1, 0.4, 3)
            world.add(
                "box", half, (*rng.uniform(-0.04, 0.04, 2), z + half[2]), float(rng.uniform(1, 20))
            )
            z += 2 * half[2]
    elif kind == "slope":
        angle = rng.uniform(0.1, 0.45)
        turn, up = (
            world.bullet.getQuaternionFromEuler((0, angle, 0)),
            np.array([np.sin(angle), 0, np.cos(angle)]),
        )
        world.add("box", (3, 3, 0.2), (0, 0, 2), 0, turn)
        half, other = rng.uniform(0.15, 0.4, 3), rng.uniform(0.1, 0.2, 3)
        at = np.array([0, 0, 2]) + up * (0.2 + half[2])
        world.add("box", half, at, float(rng.uniform(1, 20)), turn, 1.0)
        world.add(
            "box", other, at + up * (half[2] + other[2]), float(rng.uniform(1, 20)), turn, 1.0
        )
    elif kind == "table":
        for x in (-0.8, 0.8):
            world.add("box", (0.1, 0.3, 0.3), (x, 0, 0.3), 10.0)
        world.add("box", (1, 0.3, 0.05), (0, 0, 0.65), float(rng.uniform(5, 20)))
        world.add(
            "box", (0.1, 0.1, 0.1), (rng.uniform(-0.6, 0.6), 0, 0.8), float(rng.uniform(5, 30))
        )
    else:
        inside = 1.0 if kind == "pile" else 0.7
        for k in range(int(rng.integers(10, 31))):
            half, turn = rng.uniform(0.08, 0.25, 3), rng.normal(size=4)
            half = half if kind == "pile" else np.full(3, min(half[0], 0.2))
            place = (*rng.uniform(-0.4, 0.4, 2), 0.4 + 0.45 * k)
            world.add(
                "box" if kind == "pile" else "sphere",
                half,
                place,
                float(8000 * half.prod()),
                turn / np.linalg.norm(turn),
                0.5,
            )
        for x, y in ((1, 0), (-1, 0), (0, 1), (0, -1)):
            world.add("box", (0.1, 1.2, 2) if x else (1.2, 0.1, 2), (x * inside, y * inside, 2), 0)


def record() -> None:
    import pybullet

    pybullet.connect(pybullet.DIRECT)
    scenes = []
    for kind, count in KINDS.items():
        for k in range(count):
            world = World(pybullet)
            fill(world, kind, np.random.default_rng([len(kind), k]))
            scenes.append({"kind": kind, **world.rest(12 if kind in ("pile", "spheres") else 4)})
    rounded = json.loads(json.dumps(scenes), parse_float=lambda text: round(float(text), 7))
    RECORDED.write_text(
        json.dumps(rounded, separators=(",", ":")).replace('},{"kind"', '},\n{"kind"') + "\n",
        encoding="utf-8",
    )


if __name__ == "__main__":
    record()
