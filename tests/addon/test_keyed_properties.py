"""What can be keyed is traced as Blender shows it in every frame; what is read only after edits
cannot be keyed."""

from collections.abc import Callable, Iterator
from typing import Any

import bpy
import pytest
from haptic_tracing.addon.blender.compatibility import fcurves_in
from haptic_tracing.addon.scene_reader.animated_curves import FREQUENCY
from haptic_tracing.addon.scene_reader.digest import changes, digest_of
from haptic_tracing.addon.session import session, sessions

NOT_TRACED = tuple(f"haptics.{name}" for name in ("bake.", "live_output.", "meters.", "tracing"))
OVER_TIME = {FREQUENCY}
"""Read as curves, once for all frames."""


def _keyed(group: Any, path: str = "haptics.") -> Iterator[tuple[str, Any, Any]]:
    """The properties below a group that can be keyed: path, group that holds it, definition."""
    for name in type(group).__annotations__:
        prop, value = group.bl_rna.properties[name], getattr(group, name)
        here = f"{path}{name}"
        if prop.type == "COLLECTION":
            for number, item in enumerate(value):
                yield from _keyed(item, f"{here}[{number}].")
        elif isinstance(value, bpy.types.PropertyGroup):
            yield from _keyed(value, f"{here}.")
        elif prop.is_animatable and not here.startswith(NOT_TRACED):
            yield here, group, prop


def _another(prop: Any, now: Any) -> Any:
    match prop.type:
        case "BOOLEAN":
            return not now
        case "ENUM":
            return next(item.identifier for item in prop.enum_items if item.identifier != now)
        case "INT":
            return now + 1
    if prop.is_array:
        return [0.25 + 0.5 * value for value in now]
    low, high = prop.hard_min, min(prop.hard_max, prop.hard_min + 10.0)
    return low + (0.3 if now != low + 0.3 * (high - low) else 0.6) * (high - low)


def _read(scene: Any) -> str:
    known = sessions.known(scene)
    read = known and known.reading
    if read is None:
        return "nothing"
    return repr((read.objects, read.bodies, read.sources, read.listeners, read.settings)) + repr(
        read.contact_settings
    )


@pytest.fixture
def owners(scene: Any, add_box: Callable[..., Any]) -> dict[str, Any]:
    """What has properties: the scene with a rule in every table, an object that is a source and a
    listener, and the signal drawn for it."""
    box = add_box("Box", (0, 0, 0), (1, 1, 1))
    box.haptics.source.enabled = box.haptics.listener.enabled = True
    other = add_box("Other", (1, 0, 0), (1, 1, 1))
    other.haptics.source.enabled = True
    for table in ("impact_table", "transmission_table", "textures"):
        row = getattr(scene.haptics, table).items.add()
        row.first_kind, row.first = "OBJECT", "Box"
    scene.haptics.transmission_table.items[0].function = "constant"
    bpy.context.view_layer.objects.active = other
    assert bpy.ops.haptic.draw_signal() == {"FINISHED"}
    tree = other.haptics.source.drawing
    tree.haptics.emphases.add()
    return {"Scene": scene, "Box": box, "Tree": tree}


@pytest.mark.parametrize("owner", ["Scene", "Box", "Tree"])
def test_a_keyed_value_is_that_of_the_frame(scene: Any, owners: dict[str, Any], owner: str) -> None:
    block = owners[owner]
    stale, followed = [], 0
    for path, group, prop in list(_keyed(block.haptics)):
        name = prop.identifier
        first = getattr(group, name)
        first = tuple(first) if getattr(prop, "is_array", False) else first
        another = _another(prop, first)
        edited = []
        for frame, value in ((11, first), (12, another)):
            setattr(group, name, value)
            scene.frame_set(frame)
            session.result_of(scene)
            edited.append(_read(scene))
        for frame, value in ((1, first), (2, another)):
            setattr(group, name, value)
            block.keyframe_insert(path, frame=frame)
        keyed = []
        for frame in (1, 2):
            scene.frame_set(frame)
            session.result_of(scene)
            keyed.append(_read(scene))
        if edited[0] != edited[1]:
            followed += 1
            if keyed[0] == keyed[1] and path not in OVER_TIME:
                stale.append(path)
        block.animation_data_clear()
        setattr(group, name, first)
    assert stale == []
    assert followed >= {"Scene": 7, "Box": 12, "Tree": 0}[owner]


@pytest.mark.parametrize("in_meta", [False, True])
def test_a_strip_of_the_nla_switches_a_source_on(
    scene: Any, owners: Any, add_empty: Any, in_meta: bool
) -> None:
    """Also where all roles are off in the first frame that is read."""
    buzzer = add_empty("Buzzer", parent=owners["Box"])
    for frame, is_on in ((1, False), (10, True), (20, False)):
        buzzer.haptics.source.enabled = is_on
        buzzer.keyframe_insert("haptics.source.enabled", frame=frame)
    data = buzzer.animation_data
    action, data.action = data.action, None
    strip = data.nla_tracks.new().strips.new("strip", 1, action)
    if in_meta:
        _put_into_meta(buzzer, strip)
    for frame in (1, 5, 10, 19, 20):
        scene.frame_set(frame)
        heard = {source.name for source in session.result_of(scene).sources}
        assert ("Buzzer" in heard) == (10 <= frame < 20), frame
    before = digest_of(scene)
    fcurves_in(action)[0].keyframe_points[1].co[0] = 12
    assert changes(before, digest_of(scene)) == (("animation", "Buzzer"),)


def _put_into_meta(obj: Any, strip: Any) -> None:
    for other in bpy.context.view_layer.objects:
        other.select_set(other == obj)
    strip.select = True
    window = bpy.context.window_manager.windows[0]
    area = window.screen.areas[0]
    area.type = "NLA_EDITOR"
    region = next(region for region in area.regions if region.type == "WINDOW")
    with bpy.context.temp_override(window=window, area=area, region=region):
        bpy.ops.nla.meta_add()
