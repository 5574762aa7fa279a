"""Cues to what a viewport does not show of a path: where they point, checked against Blender's own
projection, and that their plates stay in sight and apart."""

from types import SimpleNamespace

import bpy
import numpy as np
import pytest
from haptic_tracing.addon.view import annotations, cues, hud
from haptic_tracing.addon.view.cues import Cue
from mathutils import Matrix

SIZE = (800, 600)
FREE = (40.0, 0.0, 700.0, 560.0)


def _perspective():
    """A viewer at the origin who looks along -Z, with a field of view of 90° across."""
    camera = bpy.data.objects.new("eye", bpy.data.cameras.new("eye"))
    camera.data.angle = np.pi / 2
    depsgraph = bpy.context.evaluated_depsgraph_get()
    return np.array(camera.calc_matrix_camera(depsgraph, x=SIZE[0], y=SIZE[1]) @ Matrix())


@pytest.mark.parametrize(
    ("position", "arrow"),
    [
        ((0, 0, -5), ""),
        ((20, 0, -5), "→"),
        ((-20, 0, -5), "←"),
        ((0, 20, -5), "↑"),
        ((0, -20, -5), "↓"),
        ((9, 8.5, -5), "↗"),
        ((20, 0, 5), "→"),
        ((-20, 0, 5), "←"),
    ],
)
def test_arrows_point_to_what_is_out_of_sight(position, arrow):
    """On the side on which it is, also behind the viewer."""
    place, found = cues._place(np.array([*position, 1.0]), _perspective(), SIZE, FREE)
    assert found == arrow
    assert FREE[0] <= place[0] <= FREE[2] and FREE[1] <= place[1] <= FREE[3]
    on_edge = min(*np.abs(np.subtract(place, FREE[:2])), *np.abs(np.subtract(place, FREE[2:])))
    assert (on_edge < 1e-6) == bool(arrow)


def test_the_path_of_a_scene_names_what_is_hidden_and_out_of_sight(
    scene, add_box, add_empty, traced, settle
):
    ground = add_box("ground", (0, 0, -5), (4, 4, 1))
    far = add_box("far", (42, 0, -5), (80, 1, 1))
    add_empty("drill", parent=ground).haptics.source.enabled = True
    add_empty("hand", parent=far).haptics.listener.enabled = True
    ground.haptics.function = far.haptics.function = "identity"
    traced()
    ground.hide_set(True)
    context = SimpleNamespace(
        scene=scene,
        region=SimpleNamespace(width=SIZE[0], height=SIZE[1]),
        space_data=None,
    )
    found = settle(lambda: cues.cues_of(context, _perspective(), FREE))
    words = [cue.words for cue in found]
    assert words == ["ground (hidden)", "→ far", "→ hand"]


def test_plates_of_cues_stay_in_sight_and_apart():
    given = [Cue(f"→ object {number}", (700.0, 20.0)) for number in range(6)]
    builder = hud.HudBuilder(1.0)
    taken = ((600.0, 0.0, 700.0, 80.0),)
    annotations._add_cues(builder, given, FREE, taken)
    plates = builder.build().bounds
    assert len(plates) == 6
    for number, plate in enumerate(plates):
        assert FREE[0] <= plate[0] and plate[2] <= FREE[2] and plate[3] <= FREE[3]
        assert not any(hud.overlaps(plate, other) for other in (*taken, *plates[:number]))
