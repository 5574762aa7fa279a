"""What the sidebar begins with: the answer, the next step, and the cure of what keeps a listener
from feeling anything."""

from dataclasses import replace
from types import SimpleNamespace

import bpy
import pytest
import recording_layout
from haptic_tracing.addon.blender import compatibility
from haptic_tracing.addon.blender.text import text_width
from haptic_tracing.addon.panels import cures, hints, listener, object, scene, source, texts
from haptic_tracing.core.message import Cause, Message
from haptic_tracing.core.scene.choices import SourceKind
from haptic_tracing.core.scene.values import Source
from hypothesis import given, settings
from hypothesis import strategies as st


def drawn(panel):
    layout = recording_layout.RecordingLayout()
    panel.draw(SimpleNamespace(layout=layout), bpy.context)
    return layout


def step(own):
    """The hint, in which the buttons below are named."""
    found = hints.next_step(own)
    return None if found is None else found.words


def test_the_hint_leads_from_an_empty_scene_to_a_listener(scene, add_box, add_empty, traced):
    assert "Make Haptic" in step(scene)
    ground = add_box("ground", (0, 0, 0), (2, 2, 1))
    traced()
    assert "Add Source" in step(scene)
    add_empty("drill", parent=ground).haptics.source.enabled = True
    traced()
    assert "Add Listener" in step(scene) and "Add Body Listeners" in step(scene)
    crate = add_box("crate", (0, 0, 1.05), (1, 1, 1))
    add_empty("hand", parent=crate).haptics.listener.enabled = True
    traced()
    assert step(scene) is None, "the answer says whether something arrives, and why not"
    scene.haptics.tracing = False
    layout = recording_layout.RecordingLayout()
    hints.next_step(scene).draw(layout)
    assert layout.properties == ["tracing"]


def test_bodies_that_fall_need_no_source(scene, add_box, traced):
    bpy.ops.rigidbody.world_add()
    add_box("ground", (0, 0, 0), (2, 2, 1), body="PASSIVE")
    add_box("crate", (0, 0, 3), (1, 1, 1), body="ACTIVE")
    traced()
    assert "Add Listener" in step(scene)
    scene.haptics.impacts = False
    assert "Add Source" in step(scene)


@pytest.mark.parametrize("what", ["impacts", "textures", "one-shot"])
def test_what_strikes_slides_or_is_triggered_needs_no_source(
    scene, add_box, add_empty, traced, what
):
    """Nor does it in the frames in which nothing sounds; a hammer that an animation moves strikes
    as well."""
    bpy.ops.rigidbody.world_add()
    ground = add_box("ground", (0, 0, 0), (2, 2, 1), body="PASSIVE")
    hammer = add_box("hammer", (0, 0, 3), (1, 1, 1), body="ACTIVE")
    hammer.rigid_body.kinematic = True
    scene.haptics.impacts = what == "impacts"
    if what == "textures":
        scene.haptics.textures.items.add()
    if what == "one-shot":
        bell = add_empty("bell", parent=ground).haptics.source
        bell.enabled = bell.one_shot = True
        bell.trigger_markers = "Bell"
        scene.timeline_markers.new("Bell", frame=5)
        bell.decay, bell.signal = 0.1, "BLAST"
    traced()
    assert "Add Listener" in step(scene)


def test_the_main_panel_begins_with_the_answer(scene, add_box, add_empty, settle):
    ground = add_box("ground", (0, 0, 0), (2, 2, 1))
    add_empty("drill", parent=ground).haptics.source.enabled = True
    add_empty("hand", (0.2, 0, 0), ground).haptics.listener.enabled = True
    bpy.context.view_layer.objects.active = bpy.data.objects["hand"]
    scene.frame_set(1)
    labels = settle(lambda: drawn(globals()["scene_panel"])).labels
    assert labels[0] == "hand"
    assert labels[1].startswith("Felt: +")
    assert labels[2:4] == ["From drill", "through ground"]


@pytest.mark.parametrize("constrained", [False, True])
def test_the_answer_says_that_a_blow_is_estimated_where_no_curve_tells_of_it(
    scene, add_box, add_empty, settle, constrained
):
    bpy.ops.rigidbody.world_add()
    ground = add_box("ground", (0, 0, -0.5), (4, 4, 1), body="PASSIVE")
    add_empty("foot", (0, 0, 0), ground).haptics.listener.enabled = True
    bpy.context.view_layer.objects.active = bpy.data.objects["foot"]
    crate = add_box("crate", (0, 0, 0.5), (1, 1, 1), body="ACTIVE", mass=20.0)
    crate.rigid_body.kinematic = True
    moved = crate
    if constrained:
        moved = add_empty("rail", (0, 0, 0), None)
        crate.constraints.new("COPY_LOCATION").target = moved
    for frame, place in ((1, 2.0), (9.5, 0.5)):
        moved.location = (0, 0, place)
        moved.keyframe_insert("location", frame=frame)
    for curve in compatibility.fcurves_of(moved):
        for key in curve.keyframe_points:
            key.interpolation = "LINEAR"
    for frame in range(1, 11):
        scene.frame_set(frame)
    words = " ".join(settle(lambda: drawn(globals()["scene_panel"])).labels)
    assert "From crate \N{MULTIPLICATION SIGN} ground" in words
    assert ("(estimated)" in words) == constrained


def test_the_answer_says_why_nothing_is_felt_with_the_cure_beside_it(
    scene, add_box, add_empty, settle
):
    ground = add_box("ground", (0, 0, 0), (2, 2, 1))
    drill = add_empty("drill", parent=ground)
    drill.haptics.source.enabled = drill.haptics.source.muted = True
    add_empty("hand", (0.2, 0, 0), ground).haptics.listener.enabled = True
    scene.frame_set(1)
    layout = settle(lambda: drawn(globals()["scene_panel"]))
    assert "Feels nothing" in layout.labels
    assert "'drill' is muted" in layout.labels
    header = recording_layout.RecordingLayout()
    globals()["why_panel"].draw_header_preset(SimpleNamespace(layout=header), bpy.context)
    assert header.properties == ["muted"]


CURED = {
    *(
        Cause.NO_SOURCE,
        Cause.MUTED,
        Cause.ZERO_AMPLITUDE,
        Cause.FINISHED,
        Cause.NEAREST_LISTENER_ONLY,
    ),
    *(
        Cause.LISTENER_GAIN,
        Cause.NOT_FELT,
        Cause.NARROW_GAP,
    ),
}


@pytest.mark.parametrize("cause", [cause for cause in Cause if cause in CURED])
def test_every_cure_draws_with_properties_that_there_are(cause, scene, add_box):
    box = add_box("box", (0, 0, 0), (1, 1, 1))
    layout = recording_layout.RecordingLayout()
    cures.draw_cure(layout, bpy.context, Message.of(cause, box.name))
    assert layout.properties or layout.operators


def test_a_reason_without_a_cure_leads_to_its_object(scene):
    layout = recording_layout.RecordingLayout()
    cures.draw_cure(layout, bpy.context, Message.of(Cause.KAPPA_ONE, "bench", object="bench"))
    assert layout.operators == ["haptic.select_object"]


def test_panels_of_roles_that_an_object_does_not_have_are_folded(add_box):
    bpy.context.view_layer.objects.active = add_box("box", (0, 0, 0), (1, 1, 1), haptic=False)
    for panel in (object.HAPTIC_PT_object, source.HAPTIC_PT_source, listener.HAPTIC_PT_listener):
        assert not vars(drawn(panel))["properties"]
    assert not object.HAPTIC_PT_constants.poll(bpy.context)


@settings(derandomize=True, deadline=None, max_examples=60)
@given(
    st.text(st.characters(codec="ascii", categories=["L", "N", "Zs"]), max_size=120),
    st.sampled_from([200.0, 160.0, 90.0]),
)
def test_lines_keep_all_words_and_fit(text, width):
    found = texts.lines(text, width)
    assert " ".join(found).split() == text.split()
    for line in found:
        assert text_width(line, texts.font_size()) <= width or " " not in line


@pytest.mark.parametrize("share", [1.0, 0.8, 0.3])
def test_long_names_keep_both_ends(share, monkeypatch):
    monkeypatch.setattr(
        texts, "content_width", lambda: 0.8 * texts._WIDTH
    )  # a sidebar 20 % narrower
    name = "the upper shelf of the old kitchen cupboard behind the door.R"
    cut = texts.fitted(name, share)
    assert text_width(cut, texts.font_size()) <= 0.8 * texts._WIDTH * share
    assert cut[0] == "t" and cut.endswith(".R")


def test_both_objects_of_an_impact_stay_readable():
    impact = Source("impact of Hammer of the blacksmith and Anvil of the blacksmith at 0.7916 "
"s", "Hammer of the blacksmith",
                    second_object="Anvil of the blacksmith", second_position=(0, 0, 0), kind=SourceKind.TEMPORARY)  # fmt: skip
    title = texts.source_title(impact)
    first, second = title.split(" × ")
    assert first[0] == "H" and second[0] == "A"
    assert text_width(title, texts.font_size()) <= texts._WIDTH
    assert texts.source_title(replace(impact, object="Nail", second_object="Wood")) == "Nail × Wood"


scene_panel, why_panel = scene.HAPTIC_PT_scene, scene.HAPTIC_PT_why
