"""``haptic-tracing contacts``: the contacts of a scene file, found from shapes and poses."""

from __future__ import annotations

import argparse

from ..core.run_time import load
from . import print_json


def run(args: argparse.Namespace) -> int:
    """Print ``{"contacts": [...]}`` in the format of the scene file, each contact with its signed
    ``distance`` in metres."""
    scene = load(args.scene)
    contacts = scene.contacts_found(args.tolerance)
    names = [item.name for item in scene.content.objects]
    forms = [
        {
            "objects": [names[a], names[b]],
            "positions": contacts.positions[i].tolist(),
            "transmission": {"function": "identity"},
            "area": float(contacts.area[i]),
            "normal": contacts.normal[i].tolist(),
            "depth": float(contacts.depth[i]),
            "distance": float(contacts.distance[i]),
            "weight": float(contacts.weight[i]),
        }
        for i, (a, b) in enumerate(contacts.pairs.tolist())
    ]
    print_json({"contacts": forms}, args.stdout)
    return 0
