"""A device family of a plug-in, and its profile, are found beside those that are built in."""

import json
from dataclasses import replace
from types import SimpleNamespace

import pytest
from haptic_tracing.core import plugins
from haptic_tracing.core.devices.families.pads import pad
from haptic_tracing.core.devices.families.registry import FAMILIES, family
from haptic_tracing.core.devices.profile_files import BUILT_IN, load_profiles


@pytest.fixture
def offered(tmp_path):
    """A plug-in with the family of another pad under a name of its own."""
    made_up = replace(pad("luna"), name="made-up")
    document = json.loads((BUILT_IN / "luna.json").read_text()) | {
        "name": "made-up-pad",
        "family": "made-up",
    }
    (tmp_path / "profiles").mkdir()
    (tmp_path / "profiles" / "made-up.json").write_text(json.dumps(document))
    plugin = SimpleNamespace(DEVICES=(made_up,), __file__=str(tmp_path / "__init__.py"))
    plugins.plugins()
    plugins.add("made up", lambda: plugin)
    yield made_up
    plugins.remove("made up")


def test_family_and_profile_of_a_plug_in(offered):
    assert family("made-up") is offered and "made-up" not in FAMILIES
    profiles, problems = load_profiles()
    assert profiles["made-up-pad"].family is offered and problems == ()


def test_without_it_they_are_gone():
    with pytest.raises(ValueError, match="device 'made-up' is unknown"):
        family("made-up")
    assert "made-up-pad" not in load_profiles()[0]
