"""Built-in profiles against an independent validator, and broken ones: one line with the place, and
the others go on."""

import json
import math
from itertools import pairwise

import jsonschema
import pytest
from haptic_tracing.core.devices.families.registry import families
from haptic_tracing.core.devices.profile_files import (
    BUILT_IN,
    load_profiles,
    parse_profile,
    profile,
)
from haptic_tracing.core.devices.profiles import Calibration
from haptic_tracing.core.formats.io.schema import SCHEMAS
from haptic_tracing.core.scene.body import PAPER_LISTENERS

SCHEMA = json.loads((SCHEMAS / "device.schema.json").read_text())
FILES = sorted(BUILT_IN.glob("*.json"))
OFFERED = sorted(BUILT_IN.parents[2].glob("plugins/*/profiles/*.json"))


@pytest.mark.parametrize("file", [*FILES, *OFFERED], ids=lambda file: file.stem)
def test_profiles_are_valid_and_named_like_their_file(file):
    jsonschema.Draft7Validator.check_schema(SCHEMA)
    jsonschema.Draft7Validator(SCHEMA).validate(json.loads(file.read_text()))
    loaded = parse_profile(file.read_bytes(), file)
    assert loaded.name == file.stem
    assert all(
        part in PAPER_LISTENERS for actuator in loaded.actuators for part in actuator.body_parts
    )
    assert {channel.name for actuator in loaded.actuators for channel in actuator.channels} <= set(
        loaded.family.channels
    )
    for actuator in loaded.actuators:
        takes = [channel.takes for channel in actuator.channels]
        assert all(lower[1] == upper[0] for lower, upper in pairwise(takes)), (
            "a gap or overlap between channels"
        )


def test_every_family_has_a_profile_and_all_load():
    profiles, problems = load_profiles()
    assert problems == ()
    assert {loaded.family.name for loaded in profiles.values()} == set(families())


@pytest.mark.parametrize("loaded", load_profiles()[0].values(), ids=lambda loaded: loaded.name)
def test_touch_never_lags_the_picture_by_more_than_the_actuator_forces_it_to(loaded):
    """50 ms is what people do not notice; only eccentric motors can't keep it."""
    for transport in loaded.family.transports:
        if loaded.actuators[0].kind != "ERM" and "joycon" not in loaded.name:
            assert loaded.latency + loaded.interval(transport) / 2 <= 0.050


def changed(**changes):
    document = json.loads((BUILT_IN / "dualsense.json").read_text())
    for place, value in changes.items():
        *steps, last = place.split("__")
        target = document
        for step in steps:
            target = target[int(step) if step.isdigit() else step]
        last = int(last) if last.isdigit() else last
        if value is None:
            del target[last]
        else:
            target[last] = value
    return json.dumps(document)


NESTED = (
    "description",
    "actuators__0__body_parts",
    "actuators__0__body_parts__0",
    "actuators__0__position",
    "sustained",
)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "the file is empty"),
        ("{", "not JSON: "),
        ("[" * 100_000, "nested deeper than 100 levels"),
        ('{"slew": NaN}', "/slew: NaN is not a JSON number"),
        ("[]", "must be an object, got an array"),
        (changed(format="haptic-toaster"), "/format: must be"),
        (changed(version="2.0"), "/version: must be"),
        (changed(family="toaster"), "/family: 'toaster' is unknown: use one of dualsense"),
        (changed(name="Über"), "/name: must match"),
        (changed(actuators=[]), "/actuators: must have at least 1 item"),
        (changed(actuators__0__band=[400, 20]), "/actuators/0/band: 400.0 Hz is not below 20.0 Hz"),
        (
            changed(actuators__1__channels__0__takes=[10, 10]),
            "/actuators/1/channels/0/takes: 10.0 Hz is not below 10.0 Hz",
        ),
        (changed(actuators__0__band=[20]), "/actuators/0/band: must have at least 2 items"),
        (changed(actuators__0__safe_maximum=1.5), "/actuators/0/safe_maximum: must be at most 1"),
        (changed(actuators__0__latency=-1), "/actuators/0/latency: must be at least 0"),
        (changed(actuators__0__kind="piezo"), "/actuators/0/kind: must be "),
        (
            changed(actuators__0__body_parts=["tail"]),
            "/actuators/0/body_parts/0: body part 'tail' is unknown",
        ),
        (
            changed(actuators__0__channels__0__name="middle"),
            "/actuators/0/channels/0/name: dualsense has no channel 'middle'",
        ),
        (
            changed(actuators__1__channels__0__name="left"),
            "/actuators/1/channels/0/name: channel 'left' is used twice",
        ),
        (changed(actuators__1__name="left grip"), "/actuators/1/name: 'left grip' is used twice"),
        (
            changed(minimum_interval=0.001),
            "/minimum_interval: 0.001 s is faster than the device allows",
        ),
        (changed(actuators__0__wattage=3), "/actuators/0/wattage: unknown key"),
        (changed(**{"w" * 5000: 3}), "/www"),
        (changed(family="t" * 5000), "/family: "),
        *(
            (changed(**{place: [[]]}).replace("[[]]", "[" * depth + "]" * depth), "nested deeper")
            for place in NESTED
            for depth in (300, 990)
        ),
        (changed(sustained__maximum=None), "/sustained/maximum: is required"),
    ],
)
def test_a_broken_profile_says_where_and_what_in_one_line(text, message):
    with pytest.raises(ValueError) as caught:
        parse_profile(text.encode(), "pad.json")
    assert str(caught.value).startswith(f"pad.json: {message}")
    assert "\n" not in str(caught.value) and len(str(caught.value)) < 600


def test_samples_go_to_one_channel_per_actuator():
    document = json.loads((BUILT_IN / "dualsense-pcm.json").read_text())
    document["actuators"][0]["channels"].append({"name": "right", "takes": [10, 100]})
    with pytest.raises(ValueError, match="/actuators/0/channels: dualsense-pcm takes samples"):
        parse_profile(json.dumps(document).encode(), "pad.json")


def test_broken_files_do_not_keep_the_others_from_loading(tmp_path):
    (tmp_path / "broken.json").write_text("{")
    (tmp_path / "latin.json").write_bytes(b'{"name": "\xe9"}')
    (tmp_path / "folder.json").mkdir()
    (tmp_path / "mine.json").write_text(changed(name="dualsense", title="My DualSense"))
    (tmp_path / "twice.json").write_text(changed(name="dualsense"))
    profiles, problems = load_profiles([BUILT_IN, tmp_path])
    assert profiles["dualsense"].title == "My DualSense"
    assert set(profiles) == {file.stem for file in (*FILES, *OFFERED)}
    assert [problem.split(":")[0].rsplit("/", 1)[1] for problem in problems] == [
        "broken.json",
        "folder.json",
        "latin.json",
        "twice.json",
    ]
    assert "is used by another file" in problems[-1]


def test_an_unknown_profile_is_named():
    with pytest.raises(ValueError, match="device 'toaster' is unknown: use one of "):
        profile("toaster")


@pytest.mark.parametrize(
    ("field", "value"),
    [("gain", -1), ("gain", math.nan), ("floor", 1.0), ("floor", math.nan), ("exponent", 0.0)],
)
def test_calibrations_out_of_range_are_refused(field, value):
    with pytest.raises(ValueError, match=field):
        Calibration(**{field: value})
