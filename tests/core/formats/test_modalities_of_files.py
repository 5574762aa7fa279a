"""Warmth in haptic scene files: whole, checked, and felt as the modality says."""

import json
import math

import jsonschema
import pytest
from haptic_tracing.core.formats.export import Export
from haptic_tracing.core.formats.haptic_scene import read_export, write_export
from haptic_tracing.core.formats.io.error import FormatError
from haptic_tracing.core.formats.io.schema import load_schema
from haptic_tracing.core.modalities import THERMAL
from haptic_tracing.core.modalities.propagation import Emitter, ModalityScene
from haptic_tracing.core.modalities.thermal import JOINT
from haptic_tracing.core.scene.values import Contact, HapticObject, HapticScene, Listener
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

REFERENCE = jsonschema.Draft202012Validator(load_schema("haptic-scene-1.1"))
NAMES = ("bench", "hearth", "rug")
BENCH = HapticScene(
    objects=tuple(HapticObject(name, 0.1, 0.9) for name in NAMES),
    contacts=(Contact(("bench", "hearth"), ((0.4, 0, 0), (0.4, 0, 0)), area=0.1),),
    listeners=(Listener("seat", "bench", (1.2, 0, 0)),),
)


def quantity(value):
    return st.floats(value.low, value.high)


functions = st.sampled_from(
    [
        {"function": "exponential", "alpha": 0.8},
        {"function": "linear", "range": 4.0},
        {"function": "constant", "gain": 0.25},
        {"function": "expression", "expression": "exp(-d)"},
        {"function": "conduction"},
    ]
)
warmth = st.builds(
    ModalityScene,
    st.just(THERMAL),
    st.dictionaries(
        st.sampled_from(NAMES),
        st.fixed_dictionaries(
            {}, optional={name: quantity(item) for name, item in THERMAL.quantities.items()}
        ).filter(bool),
    ),
    st.dictionaries(st.sampled_from(NAMES), functions),
    st.dictionaries(
        st.text(min_size=1, max_size=9),
        st.tuples(st.sampled_from(NAMES), quantity(THERMAL.source_value)),
        max_size=3,
    ).map(
        lambda found: tuple(
            Emitter(name, on, (0.1, 0.2, 0.3), value) for name, (on, value) in sorted(found.items())
        )
    ),
    st.booleans(),
)


@pytest.mark.slow
@settings(max_examples=80, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
@given(warmth)
def test_writing_and_reading_gives_the_same_and_again_the_same_bytes(tmp_path_factory, thermal):
    folder = tmp_path_factory.mktemp("warm")
    write_export(Export("a", BENCH, modalities=(thermal,)), folder / "a.json")
    REFERENCE.validate(json.loads((folder / "a.json").read_text("utf-8")))
    again = read_export(folder / "a.json")
    assert again.modalities == (() if thermal.is_empty else (thermal,))
    write_export(again, folder / "b.json")
    assert (folder / "b.json").read_bytes() == (folder / "a.json").read_bytes()


def test_files_without_the_section_are_as_they_were(tmp_path):
    write_export(Export("a", BENCH), tmp_path / "a.json")
    assert "modalities" not in json.loads((tmp_path / "a.json").read_text())
    assert read_export(tmp_path / "a.json").modalities == ()


def test_what_is_felt_is_the_closed_form(tmp_path):
    stone = {"conductivity": 2.8, "thickness": 0.3}
    thermal = ModalityScene(
        THERMAL,
        {"bench": stone, "hearth": stone},
        {},
        (Emitter("fire", "hearth", (0, 0, 0), 60.0),),
    )
    write_export(Export("a", BENCH, modalities=(thermal,)), tmp_path / "a.json")
    export = read_export(tmp_path / "a.json")
    felt = export.modalities[0].felt_in(export.scene)
    m = math.sqrt(20 / (2.8 * 0.3))
    assert felt.values[0] == pytest.approx(
        60 * math.exp(-m * 1.2) * JOINT / (JOINT + 2.8 * m), rel=1e-12
    )


FIRE = {"name": "fire", "object": "hearth", "position": [0, 0, 0], "value": 60}


@pytest.mark.parametrize(
    ("section", "pointer", "reason"),
    [
        ({"smell": {}}, "/modalities/smell", "there is no modality 'smell'; known are thermal"),
        ({"vibrotactile": {}}, "/modalities/vibrotactile", "there is no modality"),
        ({"thermal": 3}, "/modalities/thermal", "must be an object"),
        ({"thermal": {"warm": 1}}, "/modalities/thermal/warm", "unknown key"),
        ({"thermal": {"objects": [{"object": "moon"}]}}, "/modalities/thermal/objects/0/object", "there is no object 'moon'"),
        ({"thermal": {"objects": [{"object": "rug"}] * 2}}, "/modalities/thermal/objects/1/object", "occurs twice"),
        (
            {"thermal": {"objects": [{"object": "rug", "values": {"kappa": 1}}]}},
            "/modalities/thermal/objects/0/values/kappa",
            "unknown key",
        ),
        (
            {"thermal": {"objects": [{"object": "rug", "values": {"thickness": 0}}]}},
            "/modalities/thermal/objects/0/values/thickness",
            "must be from 0.001 to 10 m",
        ),
        (
            {"thermal": {"objects": [{"object": "rug", "propagation": {"function": "haptic_tracing"}}]}},
            "/modalities/thermal/objects/0/propagation",
            "function: unknown 'haptic_tracing'",
        ),
        (
            {"thermal": {"objects": [{"object": "rug", "propagation": {"function": "expression", "expression": "import os"}}]}},
            "/modalities/thermal/objects/0/propagation",
            "expression",
        ),
        (
            {"thermal": {"objects": [{"object": "rug", "propagation": {"function": "conduction", "thickness": 1}}]}},
            "/modalities/thermal/objects/0/propagation/thickness",
            "belongs under values",
        ),
        ({"thermal": {"sources": [{**FIRE, "object": "moon"}]}}, "/modalities/thermal/sources/0/object", "there is no object 'moon'"),
        ({"thermal": {"sources": [FIRE, FIRE]}}, "/modalities/thermal/sources/1/name", "there is a source 'fire' already"),
        ({"thermal": {"sources": [{**FIRE, "value": 5000}]}}, "/modalities/thermal/sources/0/value", "must be from -100 to 1000 K"),
        ({"thermal": {"sources": [{"name": "fire", "object": "hearth", "position": [0, 0, 0]}]}}, "/modalities/thermal/sources/0/value",
         "is required"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_said_with_its_place(tmp_path, section, pointer, reason):
    write_export(Export("a", BENCH), tmp_path / "a.json")
    document = json.loads((tmp_path / "a.json").read_text())
    (tmp_path / "a.json").write_text(json.dumps({**document, "modalities": section}))
    with pytest.raises(FormatError) as caught:
        read_export(tmp_path / "a.json")
    assert caught.value.pointer == pointer and reason in caught.value.reason
