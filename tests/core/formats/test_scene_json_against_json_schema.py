"""The haptic scene file: the schema against the draft's own meta-schema, our validator against
`jsonschema`, files against files."""

import copy
import gzip
import json
import math
from dataclasses import MISSING
from itertools import permutations

import jsonschema
import pytest
from haptic_tracing.core.contacts.shapes import (
    Box,
    Capsule,
    Compound,
    Cone,
    ConvexHull,
    Cylinder,
    Mesh,
    Sphere,
)
from haptic_tracing.core.formats.io.error import FormatError
from haptic_tracing.core.formats.io.schema import load_schema, validate
from haptic_tracing.core.formats.scene.scene_json import (
    scene_from_dict,
    scene_to_dict,
    valid_document,
)
from haptic_tracing.core.scene.functions import (
    Constant,
    Exponential,
    Expression,
    HapticTracing,
    Identity,
    Linear,
    Spectrum,
)
from haptic_tracing.core.scene.values import (
    Contact,
    HapticObject,
    HapticScene,
    Listener,
    Mode,
    Pose,
    Settings,
    Source,
    SourceKind,
    Strategy,
)
from haptic_tracing.core.signals import (
    SIGNAL_KINDS,
    Adsr,
    Automation,
    Decay,
    DecayingSine,
    Delay,
    Gain,
    Impulse,
    Keyed,
    Loop,
    Noise,
    Pulse,
    Sampled,
    Saw,
    Sine,
    Square,
    Triangle,
)
from haptic_tracing.core.signals.base import json_fields
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from written_scenes import read_scene, write_scene

SCHEMA = load_schema("haptic-scene-1.1")
REFERENCE = jsonschema.Draft202012Validator(SCHEMA)

unit = st.floats(0, 1)
metres = st.floats(-1e6, 1e6)
length = st.floats(1e-3, 1e3)
vectors = st.tuples(metres, metres, metres)
names = st.text(st.characters(exclude_categories=("Cs",)), min_size=1, max_size=12)
extras = st.dictionaries(names, st.one_of(st.none(), st.booleans(), unit, names), max_size=2)
spectra = st.builds(
    Spectrum,
    band_gains=st.one_of(st.just(()), st.tuples(*[unit] * 6)),
    band_decays=st.one_of(st.just(()), st.tuples(*[st.floats(0, 100)] * 6)),
    wave_speed=st.floats(0, 5000),
)
functions = st.one_of(
    st.builds(Identity, spectrum=spectra),
    st.builds(HapticTracing, spectrum=spectra),
    st.builds(Constant, gain_value=unit, spectrum=spectra),
    st.builds(Exponential, alpha=st.floats(0, 10), spectrum=spectra),
    st.builds(Linear, range=length, spectrum=spectra),
    st.builds(
        Expression,
        expression=st.sampled_from(["x * exp(-d)", "1 / (1 + d)", "x * min(rho, kappa)"]),
        spectrum=spectra,
    ),
)
rotations = st.tuples(*[st.floats(-1, 1)] * 4).filter(lambda q: math.hypot(*q) > 0.01)
poses = st.builds(Pose, position=vectors, rotation=rotations)
solids = st.one_of(
    st.builds(Box, size=st.tuples(length, length, length), margin=unit),
    st.builds(Sphere, radius=length),
    st.builds(Capsule, radius=length, height=length),
    st.builds(Cylinder, radius=length, height=length, margin=unit),
    st.builds(Cone, radius=length, height=length),
    st.just(ConvexHull(points=[[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])),
    st.just(Mesh(points=[[0, 0, 0], [1, 0, 0], [0, 1, 0]], triangles=[[0, 1, 2]])),
)
shapes = st.one_of(
    solids,
    st.builds(
        Compound.of, children=st.lists(st.tuples(solids, poses), min_size=1, max_size=2).map(tuple)
    ),
)
swept = Sine(Automation([0, 1], [40, 80])) * Keyed(Automation([0, 2], [1, 0]))
signals = st.sampled_from(
    [
        Sine(60.0),
        swept,
        Loop(DecayingSine(150.0, 0.03), count=3) + Pulse(25.0, duty=0.2) * Adsr(hold=0.5),
        Delay(Sampled([0.0, 1.0, 0.0], 100.0), 0.5)
        >> Noise(seed=2**64 - 1) * SIGNAL_KINDS["constant"](0.5, 0.1),
        Gain(Triangle(30.0), Automation([0, 1], [0, 1])) * Decay(0.5)
        + Square(40.0) * 0.1
        + Saw(50.0)
        + Impulse(0.01),
    ]
)


unique_names = st.lists(names, min_size=2, max_size=4, unique=True)
few_names = st.lists(names, max_size=2, unique=True)
# Made once and not in every drawing, which would take longer than to draw; objects are numbers
# until their names are drawn.
members = {
    HapticObject: st.fixed_dictionaries(
        {
            "kappa": unit,
            "rho": unit,
            "propagation": functions,
            "shape": st.one_of(st.none(), shapes),
            "pose": st.one_of(st.none(), poses),
            "mass": st.one_of(st.none(), length),
            "medium": st.booleans(),
            "extras": extras,
        }
    ),
    Contact: st.fixed_dictionaries(
        {
            "positions": st.tuples(vectors, vectors),
            "transmission": functions,
            "area": st.floats(0, 10),
            "normal": st.sampled_from([(0.0, 0.0, 1.0), (0.6, 0.0, 0.8), (-1.0, 0.0, 0.0)]),
            "depth": metres,
            "share": unit,
            "extras": extras,
        }
    ),
    Source: st.fixed_dictionaries(
        {
            "position": vectors,
            "amplitude": unit,
            "kind": st.sampled_from(SourceKind),
            "signal": st.one_of(st.none(), signals),
            "onset": st.floats(0, 100),
            "priority": st.floats(0, 100),
            "extras": extras,
        }
    ),
    Listener: st.fixed_dictionaries(
        {
            "position": vectors,
            "body_part": st.sampled_from(["", "hand.L"]),
            "radius": unit,
            "gain": st.floats(0, 10),
            "mixing": st.just("custom"),
            "s_max": st.floats(0.1, 1),
            "mixing_expression": st.sampled_from(["s_max * tanh(sum / s_max)", "0.5 * strongest"]),
            "limiter": st.booleans(),
            "extras": extras,
        }
    ),
}
some_settings = st.builds(
    Settings,
    mode=st.sampled_from(Mode),
    strategy=st.sampled_from(Strategy),
    max_connections=st.one_of(st.none(), st.integers(0, 1000)),
    threshold=unit,
    epsilon=unit,
)
some_object = {count: st.sampled_from(range(count)) for count in (2, 3, 4)}
two_objects = {count: st.sampled_from(list(permutations(range(count), 2))) for count in (2, 3, 4)}
any_or_none = {count: st.sampled_from([None, *range(count)]) for count in (2, 3, 4)}
up_to_three = st.integers(0, 3)


@st.composite
def scenes(draw):
    object_names = draw(unique_names)
    count = len(object_names)

    def second_object():
        number = draw(any_or_none[count])
        return None if number is None else object_names[number]

    return HapticScene(
        objects=tuple(
            HapticObject(name=name, **draw(members[HapticObject])) for name in object_names
        ),
        contacts=tuple(
            Contact(
                objects=tuple(object_names[k] for k in draw(two_objects[count])),
                **draw(members[Contact]),
            )
            for _ in range(draw(up_to_three))
        ),
        sources=tuple(
            Source(
                name=name,
                object=object_names[draw(some_object[count])],
                second_object=second_object(),
                **draw(members[Source]),
            )
            for name in draw(few_names)
        ),
        listeners=tuple(
            Listener(
                name=name, object=object_names[draw(some_object[count])], **draw(members[Listener])
            )
            for name in draw(few_names)
        ),
        settings=draw(some_settings),
        extras=draw(extras),
    )


def accepted(document):
    """Whether our validator takes the document."""
    try:
        validate(document, "haptic-scene-1.1", "scene.json")
    except FormatError:
        return False
    return True


def test_the_schema_is_a_valid_2020_12_schema_in_which_every_number_is_bounded():
    jsonschema.Draft202012Validator.check_schema(SCHEMA)

    def parts(node):
        if isinstance(node, dict):
            yield node
            for value in node.values():
                yield from parts(value)
        elif isinstance(node, list):
            for value in node:
                yield from parts(value)

    for part in parts(SCHEMA):
        if part.keys() == {"type"}:
            continue  # narrows what is bounded elsewhere
        kinds = part.get("type", [])
        if {"number", "integer"} & set([kinds] if isinstance(kinds, str) else kinds):
            assert "maximum" in part and ("minimum" in part or "exclusiveMinimum" in part), part
        if kinds == "array":
            assert "maxItems" in part and "items" in part, part


def test_the_schema_knows_every_signal_with_every_parameter():
    definition = SCHEMA["$defs"]["signal"]
    assert definition["properties"]["signal"]["enum"] == list(SIGNAL_KINDS)
    for kind, cls in SIGNAL_KINDS.items():
        parameters = json_fields(cls)
        conditions = [
            (entry["if"]["properties"]["signal"], entry["then"]) for entry in definition["allOf"]
        ]
        (rule,) = (
            then
            for condition, then in conditions
            if kind in condition.get("enum", [condition.get("const")])
        )
        assert (
            set(rule["propertyNames"]["enum"])
            == {"signal", *parameters}
            <= {"signal", *definition["properties"]}
        )
        assert set(rule.get("required", [])) == {
            key for key, entry in parameters.items() if entry.default is MISSING
        }


@pytest.mark.slow
@settings(
    max_examples=60, deadline=None, derandomize=True, suppress_health_check=[HealthCheck.too_slow]
)
@given(scenes())
def test_writing_and_reading_gives_the_same_scene_and_again_the_same_bytes(tmp_path_factory, scene):
    folder = tmp_path_factory.mktemp("scene")
    document = json.loads(json.dumps(scene_to_dict(scene)))
    REFERENCE.validate(document)
    write_scene(scene, folder / "a.json")
    assert read_scene(folder / "a.json") == scene
    write_scene(read_scene(folder / "a.json"), folder / "b.json.gz")
    assert gzip.decompress((folder / "b.json.gz").read_bytes()) == (folder / "a.json").read_bytes()
    assert sorted(path.name for path in folder.iterdir()) == ["a.json", "b.json.gz"]


@pytest.mark.parametrize("version", ["1.0", "1.2", "2.0", "1", 1.1, None, "", ["1.1"]])
def test_other_versions_are_refused(version):
    with pytest.raises(FormatError, match=r'/version: this reads version "1\.1", not '):
        valid_document({"format": "haptic-scene", "version": version, "objects": []}, "a.json")


ODD_SHAPES = [{"function": "linear"}, {"type": "box"}, {"pose": {}}]
ODD = [
    *ODD_SHAPES,
    None,
    True,
    -1,
    0,
    0.5,
    1.0,
    2,
    2.5,
    1e300,
    10**30,
    "",
    "x",
    "identity",
    "box",
    "HT",
    [],
    [0],
    [0, 0, 0],
    {},
]


def places(document, path=()):
    yield path
    items = (
        document.items()
        if isinstance(document, dict)
        else enumerate(document)
        if isinstance(document, list)
        else ()
    )
    for key, value in items:
        yield from places(value, (*path, key))


def mutate(document, data):
    """Replace, delete or add a value somewhere in the document."""
    path = data.draw(st.sampled_from([p for p in places(document) if p] or [("x",)]))
    parent = document
    for key in path[:-1]:
        parent = parent[key]
    match data.draw(st.sampled_from(["replace", "delete", "add"])):
        case "replace":
            parent[path[-1]] = copy.deepcopy(data.draw(st.sampled_from(ODD)))
        case "delete":
            del parent[path[-1]]
        case "add" if isinstance(parent, dict):
            key = data.draw(st.sampled_from(["gain", "size", "pose", "unknown", "a.b[0]"]))
            parent[key] = copy.deepcopy(data.draw(st.sampled_from(ODD)))
        case "add":
            parent.append(copy.deepcopy(data.draw(st.sampled_from(ODD))))


@pytest.mark.slow
@settings(
    max_examples=75, deadline=None, derandomize=True, suppress_health_check=[HealthCheck.too_slow]
)
@given(scenes(), st.data())
def test_our_validator_and_jsonschema_agree_on_mutated_scenes(scene, data):
    """Four times of each scene, as scenes take longest to generate."""
    good = json.dumps(scene_to_dict(scene))
    for _ in range(4):
        document = json.loads(good)
        for _ in range(data.draw(st.integers(1, 2))):
            mutate(document, data)
        assert accepted(document) == REFERENCE.is_valid(document)
        try:
            scene_from_dict(document, "scene.json")
        except FormatError as error:
            assert str(error).startswith("scene.json: /") and str(error).isprintable()


def test_keys_that_look_like_paths_are_found(tmp_path):
    document = scene_to_dict(
        HapticScene(
            objects=(HapticObject("a", 0, 1, extras={"a.b[0]": {"a": 1}, "a": {"b[0]": [1e301]}}),)
        )
    )
    with pytest.raises(FormatError) as caught:
        scene_from_dict(document, "scene.json")
    assert caught.value.pointer == "/objects/0/extras/a/b[0]/0"
