"""``haptic-tracing contacts``: the contacts of a scene file, found from shapes and poses."""

from __future__ import annotations

import argparse
import json

from ..core.contacts.scene_contacts import contacts_of_scene
from ..core.formats.io.strict_json import read_json
from ..core.formats.scene.scene_json import current_document, scene_of
from . import warn_of_unknown


def run(args: argparse.Namespace) -> int:
    """Print ``{"contacts": [...]}`` in the format of the scene file, each contact with its signed ``distance`` in metres."""
    document, unknown = current_document(read_json(args.scene), args.scene)
    warn_of_unknown(args.scene, unknown)
    scene = scene_of(document, args.scene)
    try:
        contacts = contacts_of_scene(scene, args.tolerance)
    except ValueError as error:
        raise ValueError(f"{args.scene}: {error}") from None
    names = [item.name for item in scene.objects]
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
    print(json.dumps({"contacts": forms}, indent=1, allow_nan=False))
    return 0
