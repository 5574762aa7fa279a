"""Signals drawn in Blender: what the curves show is what is emitted, in files, as F-curves, in
libraries and on the command line."""

import json

import bpy
import numpy as np
import pytest
from haptic_tracing.addon.io import drawings, signal_library
from haptic_tracing.addon.live_output import preview
from haptic_tracing.addon.scene_reader.drawings import mapping_of, points_of, read_drawing
from haptic_tracing.addon.session import session
from haptic_tracing.core.formats import haptic_scene
from haptic_tracing.core.formats.scene.recording import traced as traced_again
from haptic_tracing.core.signals import Automation, Drawing, Emphasis, Noise

RATE = 8000
POINTS = np.array([(0.0, 0.1), (0.0371, 1.0), (0.3, 0.4), (0.8, 0.45), (1.0, 0.0)])


@pytest.fixture
def source(scene, add_box):
    """The source of the active object, with nothing drawn yet."""
    box = add_box("box", (0, 0, 0), (1, 1, 1))
    box.haptics.source.enabled = box.haptics.listener.enabled = True
    box.haptics.kappa, box.haptics.rho = 0.0, 1.0
    bpy.context.view_layer.objects.active = box
    return box.haptics.source


@pytest.fixture
def drawn(source):
    """A drawn signal of two seconds with corners, and one emphasis."""
    assert bpy.ops.haptic.draw_signal() == {"FINISHED"}
    tree = source.drawing
    tree.haptics.duration, tree.haptics.lowest, tree.haptics.highest = 2.0, 50.0, 250.0
    drawings.write_points(mapping_of(tree, "Amplitude"), POINTS)
    drawings.write_points(
        mapping_of(tree, "Frequency"), np.array([(0.0, 0.0), (0.5, 1.0), (1.0, 0.25)])
    )
    assert bpy.ops.haptic.edit_emphasis() == {"FINISHED"}
    return source


def emitted(obj=None):
    """Two seconds of what the box emits."""
    return drawings.signal_of(obj or bpy.data.objects["box"], bpy.context.scene).sample(
        0, 2 * RATE, RATE
    )


def test_what_is_drawn_is_what_is_emitted(drawn):
    times = np.arange(2 * RATE) / RATE
    envelope = np.interp(times, 2.0 * POINTS[:, 0], POINTS[:, 1])
    # The integral of straight lines between 50, 250 and 100 Hz at 0, 1 and 2 seconds.
    cycles = np.where(
        times < 1.0, 50 * times + 100 * times**2, 150 + 250 * (times - 1) - 75 * (times - 1) ** 2
    )
    burst = np.where(
        (times >= 1.0) & (times < 1.02), np.sin(2 * np.pi * (65 + 235 * 0.25) * (times - 1.0)), 0.0
    )
    np.testing.assert_allclose(
        emitted(),
        envelope * np.sin(2 * np.pi * cycles) + burst,
        rtol=0,
        atol=2e-5,
        err_msg="points are single precision",
    )


@pytest.mark.parametrize("kind", ("AUTO", "AUTO_CLAMPED"))
def test_a_rounded_curve_is_as_blender_draws_it(drawn, kind):
    mapping = mapping_of(drawn.drawing, "Amplitude")
    drawings.write_points(mapping, POINTS, ["VECTOR", "VECTOR", kind, kind, "VECTOR"])
    drawing = read_drawing(drawn.drawing)
    places = np.arange(1, 256) / 256
    mapping.initialize()
    shown = np.clip([mapping.evaluate(mapping.curves[0], place) for place in places], 0, 1)
    # Which Blender cuts off.
    corners = (np.abs(places[:, None] - POINTS[:, 0]) < 1 / 256).any(axis=1)
    assert np.abs(drawing.amplitude.at(2.0 * places) - shown)[~corners].max() < 1e-6
    assert drawing.amplitude.at(2.0 * POINTS[:-1, 0]) == pytest.approx(POINTS[:-1, 1], abs=1e-6)


def test_it_is_saved_with_the_file_and_copied_with_the_object(drawn, tmp_path):
    before = emitted()
    copy = bpy.data.objects["box"].copy()
    bpy.context.scene.collection.objects.link(copy)
    assert np.array_equal(emitted(copy), before)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "drawn.blend"))
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "drawn.blend"))
    assert np.array_equal(emitted(), before)
    assert bpy.data.objects["box"].haptics.source.drawing.users == 2


def test_a_linked_signal_is_that_of_its_library(drawn, tmp_path, add_box):
    drawn.drawing.asset_mark()
    before, name = emitted(), drawn.drawing.name
    bpy.data.libraries.write(str(tmp_path / "library.blend"), {drawn.drawing})
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    box = add_box("box", (0, 0, 0), (1, 1, 1))
    box.haptics.source.enabled, box.haptics.source.signal = True, "DRAWN"
    with bpy.data.libraries.load(str(tmp_path / "library.blend"), link=True, assets_only=True) as (
        found,
        wanted,
    ):
        assert list(found.node_groups) == [name]
        wanted.node_groups = found.node_groups
    box.haptics.source.drawing = bpy.data.node_groups[name]
    assert np.array_equal(emitted(), before)
    bpy.context.view_layer.objects.active = box
    assert not bpy.ops.haptic.edit_emphasis.poll(), "it belongs to the library"
    assert bpy.ops.haptic.draw_signal.poll()


@pytest.mark.plugins
def test_an_imported_clip_can_be_drawn_on(source, tmp_path):
    points = [
        {"time": 0.0, "amplitude": 0.0},
        {"time": 0.3, "amplitude": 1.0},
        {"time": 1.0, "amplitude": 0.2},
    ]
    envelopes = {
        "amplitude": points,
        "frequency": [{"time": 0.0, "frequency": 0.1}, {"time": 1.0, "frequency": 0.9}],
    }
    form = {
        "version": {"major": 1, "minor": 0, "patch": 0},
        "signals": {"continuous": {"envelopes": envelopes}},
    }
    (tmp_path / "clip.haptic").write_text(json.dumps(form))
    assert bpy.ops.haptic.import_signal(filepath=str(tmp_path / "clip.haptic"), loop=False) == {
        "FINISHED"
    }
    before = emitted()
    assert bpy.ops.haptic.draw_signal() == {"FINISHED"}
    assert source.signal == "DRAWN"
    assert points_of(mapping_of(source.drawing, "Amplitude"))[0] == pytest.approx(
        np.array([(0, 0), (0.3, 1), (1, 0.2)]), abs=1e-6
    )
    assert np.abs(emitted() - before).max() < 5e-5


@pytest.fixture
def own(monkeypatch, tmp_path):
    """An empty folder for the user's signals."""
    monkeypatch.setattr(signal_library, "own_folder", lambda: tmp_path / "signals")
    return tmp_path / "signals"


def test_a_signal_of_the_library_is_shared_between_files(drawn, own, add_box):
    before = emitted()
    assert bpy.ops.haptic.save_signal(name="My/Signal") == {"FINISHED"}
    (path,) = own.iterdir()
    assert path in signal_library.files()
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    bpy.context.view_layer.objects.active = add_box("box", (0, 0, 0), (1, 1, 1))
    assert bpy.ops.haptic.use_signal(filepath=str(path)) == {"FINISHED"}
    assert bpy.data.objects["box"].haptics.source.signal == "DRAWN"
    np.testing.assert_allclose(emitted(), before, rtol=0, atol=5e-5)


def test_what_can_not_be_drawn_is_kept_as_it_is(source, own):
    path = signal_library.save("Rain", Noise(0.5, seed=3))
    assert bpy.ops.haptic.use_signal(filepath=str(path)) == {"FINISHED"}
    assert source.signal == "KEPT"
    assert np.array_equal(emitted(), Noise(0.5, seed=3).sample(0, 2 * RATE, RATE))


@pytest.mark.parametrize(
    "drawing",
    (
        Drawing(Automation((0.0, 1.0), (1.0, 0.0)), Automation((0.0,), (4000.0,))),
        Drawing(Automation((0.0, 1.0), (1.0, 0.0)), Automation((0.0,), (60.0,)), 4000.0),
        Drawing(
            Automation((0.0, 1.0), (1.0, 0.0)),
            Automation((0.0,), (60.0,)),
            1.0,
            (Emphasis(0.5),) * 201,
        ),
        Drawing(
            Automation(np.linspace(0, 1, 2_000), np.linspace(0, 1, 2_000)),
            Automation((0.0,), (60.0,)),
        ),
    ),
    ids=("too high", "too long", "too many emphases", "too many points"),
)
def test_a_drawing_beyond_the_properties_is_kept_as_it_is(source, own, drawing):
    path = signal_library.save("far", drawing.to_signal())
    assert bpy.ops.haptic.use_signal(filepath=str(path)) == {"FINISHED"}
    assert source.signal == "KEPT"
    assert drawings.signal_of(bpy.data.objects["box"], bpy.context.scene) == drawing.to_signal()


@pytest.mark.parametrize("path", signal_library.files(), ids=lambda path: path.stem)
def test_the_add_ons_signals_can_be_drawn_heard_and_seen(source, path):
    signal = signal_library.read(path)
    assert bpy.ops.haptic.use_signal(filepath=str(path)) == {"FINISHED"}
    assert source.signal == "DRAWN"
    np.testing.assert_allclose(emitted(), signal.sample(0, 2 * RATE, RATE), rtol=0, atol=5e-5)
    assert np.abs(signal.sample(0, 4 * RATE, RATE)).max() <= 1.0
    _, pixels = signal_library.picture(path)
    picture = np.array(pixels).reshape(64, 64, 4)
    assert 64 < np.count_nonzero(picture[..., 3]) <= 64 * 64


@pytest.mark.parametrize(
    "text",
    (
        "",
        "[]",
        '{"signal": "sine", "frequency": NaN}',
        '{"signal": "sum", "of": []}',
        '{"a": ' * 200,
        "\0",
    ),
)
def test_a_strangers_file_is_refused_with_its_fault(source, own, text):
    own.mkdir()
    path = own / "bad.json"
    path.write_text(text)
    with pytest.raises(RuntimeError, match=r"bad\.json|must be|signal"):
        bpy.ops.haptic.use_signal(filepath=str(path))
    assert source.signal == "SINE"
    assert len(signal_library.picture(path)[1]) == 4 * 64 * 64


def test_a_strangers_drawing_is_refused_with_its_fault(drawn, scene, traced):
    tree = drawn.drawing
    tree.nodes.remove(tree.nodes["Frequency"])
    traced()
    (problem,) = session.problems_of(scene)
    assert "is damaged: it has no curve 'Frequency'" in problem.message


@pytest.mark.slow
def test_the_command_line_plays_the_same(drawn, scene, tmp_path):
    """As it goes into a scene file, a drawn signal is made of known signals; the core alone plays
    it like the add-on."""
    scene.frame_start, scene.frame_end = 1, 24
    path = tmp_path / "drawn.json"
    arguments = {
        "frames": "RANGE",
        "frame_start": 1,
        "frame_end": 24,
        "tracks": "wav",
        "encoding": "float32",
    }
    assert bpy.ops.export_scene.haptic_scene(filepath=str(path), **arguments) == {"FINISHED"}
    export = haptic_scene.read_export(path)
    (played,) = export.scene.sources
    assert np.abs(played.signal.sample(0, 2 * RATE, RATE) - emitted()).max() <= 1e-12
    blocks = [
        result.block
        for result in traced_again(export.scene, export.recording)
        if result.block is not None
    ]
    traced = np.concatenate(blocks, axis=1)
    assert np.abs(traced).max() > 0.5
    assert np.abs(export.tracks.samples - traced).max() < 1e-6


def test_a_signal_is_heard_as_it_is(drawn, monkeypatch):
    aud = pytest.importorskip("aud", reason="this bpy is built without audio")

    class Loudspeaker:
        def play(self, sound):
            self.sound, self.stopped, self.volume = sound, False, 1.0
            return self

        def stop(self):
            self.stopped = True

    loudspeaker = Loudspeaker()
    monkeypatch.setattr(preview, "_device", lambda: (aud, loudspeaker))
    assert bpy.ops.haptic.hear_signal() == {"FINISHED"}
    signal = drawings.signal_of(bpy.data.objects["box"], bpy.context.scene)
    heard = loudspeaker.sound.data()[:, 0]
    assert len(heard) == 2 * preview.RATE
    assert (
        np.abs(heard - np.tanh(signal.sample(0, 2 * preview.RATE, preview.RATE)))[:-100].max()
        < 1e-6
    )
    preview.switch_off()
    assert loudspeaker.stopped
