"""The default device is the one that Connect takes; devices that are kept awake are held at zero
when playback ends."""

import bpy
import haptic_tracing
import pytest
from fake_hid import RELEASE, ZERO, sounding, until
from haptic_tracing.addon.live_output import handlers, outputs


@pytest.fixture(autouse=True)
def preferences(scene):
    """The package enabled as an add-on, with preferences of its own."""
    haptic_tracing.unregister()
    bpy.ops.preferences.addon_enable(module="haptic_tracing")
    yield bpy.context.preferences.addons["haptic_tracing"].preferences
    bpy.ops.preferences.addon_disable(module="haptic_tracing")
    haptic_tracing.register()


@pytest.mark.parametrize(
    ("wanted", "key"),
    [("", "dualsense"), ("shock", "dualshock4"), ("SHOCK", "dualshock4"), ("nothing", "dualsense")],
)
def test_connect_takes_the_default_device(preferences, plug, wanted, key):
    plug()
    plug(vendor=0x054C, product=0x09CC)
    bpy.ops.haptic.find_devices()
    outputs.wait_until_found()
    assert [found.key for found in outputs.inventory().devices] == ["dualsense", "dualshock4"]
    preferences.default_device = wanted
    assert bpy.ops.haptic.connect_device() == {"FINISHED"}
    assert set(outputs.running()) == {key}


@pytest.mark.parametrize("awake", [False, True])
def test_devices_are_kept_awake_or_released_when_playback_ends(
    preferences, plug, connect, playing, awake
):
    preferences.keep_awake = awake
    pad = plug()
    connect()
    until(lambda: (playing(1), sounding(pad))[-1])
    handlers.animation_playback_post()
    until(lambda: pad.written[-1:] == [ZERO if awake else RELEASE])
    assert RELEASE not in pad.written[-2:-1]
    bpy.ops.haptic.panic()  # lets go of it in any case
    until(lambda: pad.closed == 1)
    assert pad.written[-2:] == [ZERO, RELEASE]
