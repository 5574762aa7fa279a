"""A new listener turns its mix down where it would be cut off, but not as in the paper."""

import bpy
import numpy as np
import pytest
from haptic_tracing.addon.session import session, timeline

RATE = 8000


@pytest.fixture
def overloaded(scene, add_box):
    """A tone of 100 Hz that is 27 dB above what its listener takes."""
    box = add_box("box", (0, 0, 0), (1, 1, 1))
    box.haptics.kappa, box.haptics.rho = 0.0, 1.0
    box.haptics.source.enabled = box.haptics.listener.enabled = True
    box.haptics.source.frequency = 100.0
    box.haptics.listener.gain, box.haptics.listener.s_max = 10.0, 10 / 10 ** (27 / 20)
    return box


def harmonics(scene):
    """The amplitudes of the multiples of 100 Hz by that of 100 Hz, in frames 25 to 48."""
    blocks = []
    for frame in range(1, 50):
        timeline.set_frame(scene, frame)
        blocks.append(session.result_of(scene).block)
    samples = np.concatenate([block[0] for block in blocks if block is not None])[-RATE:]
    spectrum = np.abs(np.fft.rfft(samples))
    return spectrum[200::100] / spectrum[100]


def test_a_new_listener_keeps_an_overloaded_sine_a_sine(overloaded, scene):
    assert overloaded.haptics.listener.limiter
    assert np.sqrt((harmonics(scene) ** 2).sum()) < 0.001
    overloaded.haptics.listener.limiter = False
    assert harmonics(scene)[1] == pytest.approx(1 / 3, rel=0.02), (
        "cut off it is nearly a square wave"
    )


@pytest.mark.parametrize("add", ["add_listener", "add_default_listeners"])
def test_buttons_add_listeners_with_a_limiter(scene, add_box, add):
    box = add_box("box", (0, 0, 0), (1, 1, 1))
    box.select_set(True)
    bpy.context.view_layer.objects.active = box
    assert getattr(bpy.ops.haptic, add)() == {"FINISHED"}
    listeners = [obj.haptics.listener for obj in bpy.data.objects if obj.haptics.listener.enabled]
    assert listeners and all(listener.limiter for listener in listeners)


def test_what_was_switched_off_stays_off(overloaded):
    overloaded.haptics.listener.limiter = False
    overloaded.haptics.listener.enabled = False
    overloaded.haptics.listener.enabled = True
    assert not overloaded.haptics.listener.limiter


def test_a_file_from_before_stays_as_it_was(overloaded, tmp_path):
    overloaded.haptics.listener.property_unset("limiter")
    path = str(tmp_path / "before.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.open_mainfile(filepath=path)
    listener = bpy.data.objects["box"].haptics.listener
    assert listener.enabled and not listener.limiter


def test_as_in_the_paper_mixes_are_cut_off(scene, add_box):
    scene.haptics.strategy = "as_in_the_paper"
    box = add_box("box", (0, 0, 0), (1, 1, 1))
    box.haptics.listener.enabled = True
    assert not box.haptics.listener.limiter
