"""What a sample's gains are in Blender, they are from its file: in Python, at run time and on the
command line."""

import json

import bpy
import haptic_tracing
import pytest
from haptic_tracing.addon.session import session
from haptic_tracing.command_line import main


@pytest.mark.slow
@pytest.mark.parametrize("name", ["kitchen", "kart"])
def test_the_gain_is_the_same_everywhere(build, name, tmp_path, capsys):
    """Of tones and drawn signals through materials that damp by frequency."""
    scene = build(name)
    scene.frame_set(scene.frame_start + 6)
    result = session.result_of(scene)
    expected = {
        (source.name, listener.name): pytest.approx(gain, rel=1e-4)
        for source, gains in zip(result.sources, result.gains.tolist(), strict=True)
        if source.amplitude > 0
        for listener, gain in zip(result.listeners, gains, strict=True)
    }
    assert len(expected) >= 12
    path = tmp_path / "sample.json"
    bpy.ops.export_scene.haptic_scene(filepath=str(path))
    loaded = haptic_tracing.load(path)
    found = loaded.gains()
    step = haptic_tracing.open(loaded).step(0.0)
    capsys.readouterr()
    assert main(["propagate", str(path)]) == 0
    printed = {
        (pair["source"], pair["listener"]): pair["path_gain"]
        for pair in json.loads(capsys.readouterr().out)["gains"]
    }
    for (source, listener), gain in expected.items():
        assert found[source, listener] == gain
        assert step.levels[listener].gains[source] == gain
        assert printed[source, listener] == gain
