"""Recorded hands as objects with keyframes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from bpy.types import Scene

from ...core.formats.export import Export
from ...core.formats.scene.recording import RecordedFrame, Recording
from ...core.scene.values import HapticScene, Listener, Pose
from ..blender.time import frame_seconds
from ..io import scene_builder
from .hands import NAMES, OBJECTS, PARTS, SHAPE, Grips


def add(scene: Scene, take: Mapping[int, Grips]) -> None:
    """Add the hands of a take to the scene: haptic objects of flesh with a listener each, and a key
    for each recorded frame of the timeline."""
    frames = sorted(take)
    poses = {
        number: {hand: Pose(*take[number][hand]) for hand in take[number]} for number in frames
    }
    first: dict[str, Pose] = {}
    for number in frames:
        first = poses[number] | first
    names = {hand: name.rstrip("\0") for hand, name in NAMES.items() if hand in first}
    hands = HapticScene(
        objects=tuple(
            replace(item, name=names[hand], shape=SHAPE, pose=first[hand])
            for hand, item in zip(NAMES, OBJECTS, strict=True)
            if hand in first
        ),
        listeners=tuple(
            Listener(f"{name}, felt", name, first[hand].position, PARTS[hand], radius=0.1)
            for hand, name in names.items()
        ),
    )
    recorded = [
        RecordedFrame(
            number,
            poses={
                names[hand]: (*pose.position, *pose.rotation)
                for hand, pose in poses[number].items()
            },
            listener_positions={
                f"{names[hand]}, felt": pose.position for hand, pose in poses[number].items()
            },
        )
        for number in frames
    ]
    if frames[-1] < scene.frame_end:  # so that the scene keeps its frames
        recorded.append(RecordedFrame(scene.frame_end))
    recording = Recording(1 / frame_seconds(scene), scene.frame_start, tuple(recorded))
    export = Export(f"VR Hands {frames[0]}-{frames[-1]}", hands, recording=recording)
    scene_builder.build(export, scene, settings=False)
