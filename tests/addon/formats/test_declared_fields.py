"""A field of a scene value is declared once: its property, its schema, its check, its reading and writing follow."""

import json

import bpy
import numpy as np
import pytest
from haptic_tracing.core.scene.declaration import Choice, Number, Switch, Text, declared, default_of, shown
from haptic_tracing.core.scene.values import Listener
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scene_files import exported, imported

FEW = settings(max_examples=40, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
HELD = [(Listener, lambda: bpy.data.objects["seat"].haptics.listener)]
ITEMS = {Listener: "listeners"}


@pytest.fixture
def plain():
    """A scene with an item of each kind."""
    return {
        "format": "haptic-scene",
        "version": "1.1",
        "objects": [{"name": "floor", "kappa": 0.1, "rho": 0.9, "shape": {"type": "box", "size": [2, 2, 0.1]}}],
        "sources": [{"name": "drill", "object": "floor", "position": [0.5, 0, 0.05]}],
        "listeners": [{"name": "seat", "object": "floor", "position": [0, 0, 0.05]}],
    }


def there_and_back(document, folder):
    """The document that Blender writes after it has read one."""
    (folder / "a.json").write_text(json.dumps(document))
    imported(folder / "a.json")
    return json.loads(exported(folder / "b.json"))


@pytest.mark.parametrize(("cls", "group"), HELD, ids=lambda part: getattr(part, "__name__", ""))
def test_properties_have_the_range_the_words_and_the_choices_of_their_fields(plain, tmp_path, cls, group):
    there_and_back(plain, tmp_path)
    owner = group()
    assert owner.held[cls].keys() == shown(cls).keys()
    for key, name in owner.held[cls].items():
        found, field = owner.bl_rna.properties[name], declared(cls)[key]
        assert found.description == field.about and found.name.startswith(field.label)
        match field:
            case Number():
                assert found.hard_max == np.float32(field.high)
                assert found.hard_min == np.float32(field.low) or (field.above and 0 < found.hard_min < 1e-30)
                if field.soft:
                    assert (found.soft_min, found.soft_max) == tuple(map(np.float32, field.soft))
            case Choice():
                assert [item.name for item in found.enum_items] == [label for label, _ in field.items.values()]


def values_of(field, default):
    """Values of a field as files may have them: its limits, and numbers with all digits."""
    match field:
        case Number(whole=True):
            return st.sampled_from([int(field.low), int(field.high)]) | st.integers(int(field.low), int(field.high))
        case Number():
            low = float(np.nextafter(field.low, field.high)) if field.above else field.low
            return (
                st.sampled_from([low, field.high])
                | st.floats(low, field.high, exclude_min=field.above)
                | st.floats(low, min(field.high, 10))
            )
        case Switch():
            return st.booleans()
        case Choice():
            return st.sampled_from(list(map(str, field.items)))
        case Text():
            return st.just(default)
    return None


@st.composite
def items(draw, cls):
    drawn = {key: values_of(field, default_of(cls, key)) for key, field in shown(cls).items()}
    item = {key: draw(values) for key, values in drawn.items()}
    if item.get("mixing") == "custom":
        item["mixing_expression"] = "0.5 * sum"
    return item


def without_defaults(cls, item):
    return {
        key: value for key, value in item.items() if value != default_of(cls, key) and json.loads(json.dumps(default_of(cls, key))) != value
    }


@pytest.mark.slow
@pytest.mark.parametrize("cls", ITEMS, ids=lambda cls: cls.__name__)
def test_what_is_untouched_comes_back_as_written(plain, tmp_path_factory, cls):
    folder = tmp_path_factory.mktemp(cls.__name__)

    @FEW
    @given(item=items(cls))
    def check(item):
        plain[ITEMS[cls]][0] = {**dict(list(plain[ITEMS[cls]][0].items())[:3]), **item}
        (found,) = there_and_back(plain, folder)[ITEMS[cls]]
        assert {key: found[key] for key in item if key in found} == without_defaults(cls, item)

    check()


def test_a_listener_with_more_digits_than_blender_has_is_imported_and_plays(plain, tmp_path, traced):
    plain["listeners"][0]["ducking"] = 12.345678912
    written = there_and_back(plain, tmp_path)
    assert written["listeners"][0]["ducking"] == 12.345678912
    (listener,) = traced().listeners
    assert listener.ducking == 12.345678912 and traced().amplitudes.max() > 0
