"""Scenes alone in files."""

from haptic_tracing.core.formats.io.strict_json import read_json
from haptic_tracing.core.formats.scene.scene_json import (
    scene_from_dict,
    scene_to_dict,
    write_document,
)


def read_scene(path):
    """The scene in a ``.json`` or ``.json.gz`` file."""
    return scene_from_dict(read_json(path), path)


def write_scene(scene, path):
    """Write a scene as ``.json``, or compressed as ``.json.gz``."""
    write_document(scene_to_dict(scene), path)
