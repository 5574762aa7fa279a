"""Every sample: built from nothing, twice the same, with all that it needs; its frames play."""

import re

import bpy
import pytest
from haptic_tracing.addon.changes.suspension import suspended
from haptic_tracing.addon.scene_reader.roles import haptic_carrier
from haptic_tracing.addon.session import session
from haptic_tracing.core.scene.body import DEFAULT_LISTENERS, PAPER_LISTENERS
from haptic_tracing.sample_scenes import SAMPLES, build_sample

FRAMES = 4
MOST_EVALUATIONS = 30
IMPORTED = ("kart", "kitchen", "boardwalk", "robot_cell")
"""Samples of imported content: names with numbers, few rigid bodies, the twelve listeners of *Add
Body Listeners*."""


def plain(name):
    """A name without the number that Blender adds."""
    return re.sub(r"\.\d{3}(?= |$)", "", name)


def listeners_of(name):
    """The body parts that feel in a sample, in order; two people walk and sit at the boardwalk."""
    parts = DEFAULT_LISTENERS if name in IMPORTED else PAPER_LISTENERS
    return sorted(parts * (2 if name == "boardwalk" else 1))


def described(scene):
    """What a sample is, as plain values."""
    found = []
    for obj in sorted(scene.objects, key=lambda o: o.name):
        body, haptics = obj.rigid_body, obj.haptics
        mesh = obj.data if obj.type == "MESH" else None
        found.append(
            (
                obj.name,
                obj.type,
                [round(value, 6) for row in obj.matrix_world for value in row],
                obj.parent.name if obj.parent else None,
                [tuple(v.co) for v in mesh.vertices] if mesh else None,
                [(tuple(p.vertices), p.material_index) for p in mesh.polygons] if mesh else None,
                [slot.material.name for slot in obj.material_slots],
                (
                    body.type,
                    body.collision_shape,
                    body.mass,
                    body.kinematic,
                    body.friction,
                    body.restitution,
                )
                if body
                else None,
                (haptics.enabled, haptics.kappa, haptics.rho, haptics.function, haptics.medium),
                (
                    haptics.source.enabled,
                    haptics.source.signal,
                    haptics.source.frequency,
                    haptics.source.amplitude,
                ),
                (haptics.listener.enabled, haptics.listener.body_part, haptics.listener.radius),
            )
        )
    return found


@pytest.mark.slow
@pytest.mark.parametrize("name", SAMPLES)
def test_first_frames_are_traced_without_a_problem_and_built_again_it_plays_beside_the_first(
    build, name
):
    """Names get a number in a file that has them already; nothing of the first sample may become
    part of the second."""
    scene = build(name)
    for frame in range(scene.frame_start, scene.frame_start + FRAMES):
        scene.frame_set(frame)
        result = session.result_of(scene)
        assert result.number == frame
        assert result.warnings == session.problems_of(scene) == ()
    assert len(result.listeners) == len(listeners_of(name))
    names = sorted(obj.name for obj in scene.objects)
    evaluated = []
    bpy.app.handlers.depsgraph_update_post.append(lambda *_: evaluated.append(None))
    with suspended():
        second = build_sample(name)
    bpy.app.handlers.depsgraph_update_post.pop()
    assert len(evaluated) <= MOST_EVALUATIONS  # not one for each object
    assert sorted(obj.name for obj in scene.objects) == names
    assert sorted(plain(obj.name) for obj in second.objects) == sorted(map(plain, names))
    assert not set(scene.objects) & set(second.objects)
    first_moving, second_moving = (
        {plain(o.name) for o in one.objects if o.animation_data and o.animation_data.action}
        for one in (scene, second)
    )
    assert first_moving == second_moving
    actions = [
        obj.animation_data.action
        for one in (scene, second)
        for obj in one.objects
        if obj.animation_data
    ]
    assert len(set(actions)) == len(actions)


@pytest.mark.slow
@pytest.mark.parametrize("name", SAMPLES)
def test_built_twice_is_identical_and_has_what_tracing_and_a_picture_need(build, name):
    first = described(build(name))
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    with suspended():
        scene = build_sample(name)
    assert described(scene) == first
    names = [row[0] for row in first]
    # For the progress shown while it is built.
    assert SAMPLES[name].objects == pytest.approx(len(names), rel=0.1)
    assert len(set(names)) == len(names)
    numbered = [n for n in names if plain(n) != n]
    assert bool(numbered) == (name in IMPORTED)
    assert [m.name for m in bpy.data.materials if re.search(r"\.\d{3}$", m.name)] == []
    haptic = [obj for obj in scene.objects if obj.haptics.enabled]
    listeners = [obj for obj in scene.objects if obj.haptics.listener.enabled]
    assert sorted(obj.haptics.listener.body_part for obj in listeners) == listeners_of(name)
    assert all(obj.type == "EMPTY" and haptic_carrier(obj.parent) in haptic for obj in listeners)
    assert scene.camera is not None
    assert {obj.type for obj in scene.objects} >= {"MESH", "EMPTY", "CAMERA", "LIGHT"}
    assert scene.rigidbody_world is not None
    alone = [obj for obj in haptic if obj.rigid_body is None and not obj.haptics.medium]
    assert len(alone) > len(haptic) / 2 if name in IMPORTED else alone == []
    assert all(obj.scale == obj.scale.__class__((1, 1, 1)) for obj in haptic)
    assert all(slot.material is not None for obj in scene.objects for slot in obj.material_slots)


def test_unknown_sample_is_named_with_the_known_ones():
    with pytest.raises(ValueError, match=r"'pyramid' is unknown: use one of jackhammer_bench"):
        build_sample("pyramid")
