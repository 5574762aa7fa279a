"""A scene for the tests of the server."""

OBJECTS = [
    {"name": "ground", "kappa": 0.1, "rho": 0.9, "motion": "static", "shape": {"type": "box", "size": [10, 10, 1]},
     "pose": {"position": [0, 0, -0.5]}},
    {"name": "crate", "kappa": 0.1, "rho": 0.9, "mass": 5, "shape": {"type": "box", "size": [1, 1, 1]},
     "pose": {"position": [0, 0, 0.5]}},
]  # fmt: skip
SCENE = {
    "objects": OBJECTS,
    "sources": [{"name": "drill", "object": "ground", "position": [2, 1, 0]}],
    "listeners": [{"name": "hand", "object": "crate", "position": [0, 0, 1], "radius": 0}],
}
