"""An object has the same values however it became haptic: by a script, *Make Haptic*, Python or a
file."""

from __future__ import annotations

import json
from dataclasses import fields
from typing import Any

import bpy
import haptic_tracing
import pytest
from haptic_tracing.addon.blender.units import metres_per_unit
from haptic_tracing.addon.scene_reader.functions import read_function
from haptic_tracing.addon.session import session
from haptic_tracing.core.scene.functions import HapticTracing, Physical
from making_haptic import make_haptic

ARM, REACH = (2.0, 0.4, 0.1), 1.5


def by_blender(add_box: Any, add_empty: Any, tag: Any, name: str) -> float:
    """The gain from one end of a bar to near the other."""
    bar = add_box(name, (0, 0, 0), ARM, haptic=False)
    bpy.context.view_layer.update()
    tag(bar)
    for role, x in (("source", 0.0), ("listener", REACH)):
        end = add_empty(f"{role} of {name}", (x / ARM[0], 0, 0), bar)
        getattr(end.haptics, role).enabled = True
    end.haptics.listener.radius = 0.0
    bpy.context.view_layer.update()
    result = session.trace(bpy.context.scene, bpy.context.evaluated_depsgraph_get())
    row = [source.object for source in result.sources].index(name)
    column = [listener.object for listener in result.listeners].index(name)
    return float(result.gains[row, column])


@pytest.mark.parametrize("material", ["steel", "concrete", "soil", "rubber", "flesh"])
def test_four_ways_give_equal_gains(scene, add_box, add_empty, tmp_path, material):
    def by_script(bar: Any) -> None:
        bar.haptics.enabled = True

    gains = [
        by_blender(add_box, add_empty, by_script, f"{material} one"),
        by_blender(add_box, add_empty, make_haptic, f"{material} two"),
    ]
    parts = {
        "objects": [
            {
                "name": "bar",
                "material": material,
                "shape": {"type": "box", "size": list(ARM)},
            }
        ],
        "sources": [{"name": "s", "object": "bar", "position": [0, 0, 0]}],
        "listeners": [{"name": "l", "object": "bar", "position": [REACH, 0, 0], "radius": 0.0}],
    }
    gains.append(haptic_tracing.Scene(**parts).gains()["s", "l"])
    path = tmp_path / "bar.json"
    path.write_text(json.dumps({"format": "haptic-scene", "version": "1.1", **parts}))
    gains.append(haptic_tracing.load(path).gains()["s", "l"])
    assert 0 < gains[0] < 1
    assert gains == pytest.approx(4 * [gains[0]], rel=1e-6)


def values(obj: Any) -> dict[str, Any]:
    haptics = obj.haptics
    function = read_function(haptics)
    return {
        "function": {item.name: getattr(function, item.name) for item in fields(function)},
        **{key: getattr(haptics, key) for key in ("kappa", "rho", "surface")},
        "material": haptics.material.name,
    }


@pytest.mark.parametrize("name", ["Anvil", "Cube", "Oak Table", "Hand.L", "Ground"])
def test_a_script_gives_what_the_button_gives(add_box, name):
    one, other = (add_box(name, (0, 0, 3 * k), (1, 2, 0.5), haptic=False) for k in range(2))
    bpy.context.view_layer.update()
    one.haptics.enabled = True
    make_haptic(other)
    assert values(one) == values(other)
    assert one.haptics.material.name and isinstance(read_function(one.haptics), Physical)


def test_what_a_script_set_before_is_kept(add_box, scene):
    box = add_box("Anvil", (0, 0, 0), (1, 1, 1), haptic=False)
    box.haptics.kappa = 0.5
    box.haptics.enabled = True
    assert (box.haptics.kappa, box.haptics.material.name) == (0.5, "Steel")
    paper = add_box("Anvil", (0, 0, 0), (1, 1, 1), haptic=False)
    paper.haptics.function = "haptic_tracing"
    paper.haptics.enabled = True
    assert isinstance(read_function(paper.haptics), HapticTracing)
    assert paper.haptics.material.name == ""
    chosen = add_box("Anvil", (0, 0, 0), (1, 1, 1), haptic=False)
    chosen.haptics.material.name = "Glass"
    chosen.haptics.enabled = True
    assert values(chosen)["function"]["phase_speed"] == pytest.approx(5200, rel=0.1)
    scene.haptics.strategy = "as_in_the_paper"
    later = add_box("Anvil", (0, 0, 0), (1, 1, 1), haptic=False)
    later.haptics.enabled = True
    assert isinstance(read_function(later.haptics), HapticTracing)


@pytest.mark.parametrize("tag", ["script", "button"])
def test_lengths_follow_the_unit_scale_however_it_was_tagged_first(add_box, scene, tag):
    scene.unit_settings.scale_length = 0.01
    box = add_box("Slab", (0, 0, 0), (100, 200, 10), haptic=False)
    bpy.context.view_layer.update()
    if tag == "script":
        box.haptics.enabled = True
    else:
        make_haptic(box)
    assert metres_per_unit(scene) == 0.01
    function = values(box)["function"]
    assert (function["thickness"], function["extent"]) == pytest.approx((0.1, 1.0))


def test_an_object_of_a_file_without_material_and_function_is_as_in_the_paper():
    read = haptic_tracing.Scene(
        objects=[{"name": "a", "kappa": 0.2, "rho": 0.9}, {"name": "b", "kappa": 0.2, "rho": 0.9}],
        contacts=[{"objects": ["a", "b"], "positions": [[1, 0, 0], [1, 0, 0]]}],
    ).content
    assert read.objects[0].propagation == HapticTracing()
    assert read.contacts[0].transmission.name == "identity"
    with pytest.raises(ValueError, match="/objects/0/kappa: is required"):
        haptic_tracing.Scene(objects=[{"name": "a", "material": "unobtainium"}])


def test_a_function_beside_a_material_is_written_and_read_again(tmp_path):
    for function in ({"function": "haptic_tracing"}, {"function": "constant", "gain": 0.5}):
        form = {"name": "a", "material": "steel", "propagation": function}
        written = haptic_tracing.Scene(objects=[form])
        again = haptic_tracing.Scene.of_values(written.content)
        assert again.content == written.content
        assert again.content.objects[0].propagation.name == function["function"]
