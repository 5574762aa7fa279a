"""Reports of Valve's devices against published protocol facts."""

import pytest
from haptic_tracing.plugins.valve.steam import STEAM_CONTROLLER_PCM
from published_reports import check, check_printed, pcm, rumble, tone_of, vectors_of

VECTORS = vectors_of(__file__)
ENCODED = {
    "steamdeck_rumble_l0.5_r0.25": lambda v: rumble("steam-deck"),
    "steam_triton_rumble_l0.5_r0.25": lambda v: rumble("steam-controller"),
    "steam_triton_pcm_config_8k8bit": lambda v: STEAM_CONTROLLER_PCM.startup("usb", 0)[0].data,
    "steam_triton_pcm_cancel": lambda v: STEAM_CONTROLLER_PCM.release("usb", 0)[0].data,
    "steam_triton_pcm_silence": lambda v: pcm(STEAM_CONTROLLER_PCM, {"input": {}}),
    "steam_triton_pcm_160hz_l0.5_r0.25": lambda v: pcm(STEAM_CONTROLLER_PCM, v),
}


@pytest.mark.parametrize("name", VECTORS)
def test_report_is_byte_exact(name):
    check(ENCODED[name](VECTORS[name]), VECTORS[name])


def test_published_samples_are_the_tone_they_claim():
    vector = VECTORS["steam_triton_pcm_160hz_l0.5_r0.25"]
    given = vector["input"]
    assert [given["left_samples"], given["right_samples"]] == tone_of(vector, 31, 8000)


@pytest.mark.parametrize(
    ("device", "vector"),
    [
        ("steam-deck", "steamdeck_rumble_l0.5_r0.25"),
        ("steam-controller", "steam_triton_rumble_l0.5_r0.25"),
    ],
)
def test_encode_prints_the_published_report(device, vector, capsys):
    check_printed(capsys, device, "", VECTORS[vector])
