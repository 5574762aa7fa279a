"""A device family of a plug-in, and its profile, are found beside those that are built in."""

import json
import sys
from dataclasses import replace
from types import SimpleNamespace

import pytest
from haptic_tracing.core import plugins
from haptic_tracing.core.devices.families.pads import pad
from haptic_tracing.core.devices.families.registry import family
from haptic_tracing.core.devices.profile_files import BUILT_IN, load_profiles


@pytest.fixture
def offered(tmp_path, monkeypatch):
    """A plug-in with the family of another pad under a name of its own, and a module that fails."""
    made_up = replace(pad("stadia"), name="made-up")
    document = json.loads((BUILT_IN / "stadia.json").read_text()) | {
        "name": "made-up-pad",
        "family": "made-up",
    }
    (tmp_path / "profiles").mkdir()
    (tmp_path / "profiles" / "made-up.json").write_text(json.dumps(document))
    monkeypatch.setitem(sys.modules, "made_up_pads", SimpleNamespace(FAMILIES=(made_up,)))
    plugin = SimpleNamespace(
        DEVICES=("made_up_pads", "missing_pads"), __file__=str(tmp_path / "__init__.py")
    )
    plugins.plugins()
    plugins.add("made up", lambda: plugin)
    yield made_up
    plugins.remove("made up")
    plugins.remove("missing_pads")


def test_family_and_profile_of_a_plug_in(offered):
    assert family("made-up") is offered
    assert plugins.failures["missing_pads"].startswith("ModuleNotFoundError")
    profiles, problems = load_profiles()
    assert profiles["made-up-pad"].family is offered and problems == ()


def test_without_it_they_are_gone():
    with pytest.raises(ValueError, match="device 'made-up' is unknown"):
        family("made-up")
    assert "made-up-pad" not in load_profiles()[0]
