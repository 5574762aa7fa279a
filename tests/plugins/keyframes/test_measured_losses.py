"""What exports say that they lose, against an evaluation of the written files by whole-signal
spectra (Parseval) and by definition."""

import json

import numpy as np
import pytest
from haptic_tracing.core.formats import registry
from haptic_tracing.core.formats.export import Export
from haptic_tracing.core.formats.io import catalogue
from haptic_tracing.core.formats.tracks.listener_tracks import ListenerTrack, Tracks
from haptic_tracing.plugins.keyframes.comparison import Comparison, Kind, Measures

RATE = 8000
WIDE = {"frequency_min": 5.0, "frequency_max": 500.0}
"""The range of an actuator that follows fast rises."""
TIME = np.arange(6 * RATE) / RATE


def noise(seed=0):
    return np.clip(np.random.default_rng(seed).normal(0, 0.15, len(TIME)), -1, 1)


def blows():
    since = TIME % 0.4
    return 0.8 * np.exp(-since / 0.03) * np.sin(2 * np.pi * 150 * since)


SIGNALS = {
    "noise": noise(),
    "tone": 0.5 * np.sin(2 * np.pi * 60 * TIME),
    "low and high": 0.3 * np.sin(2 * np.pi * 3 * TIME)
    + 0.3 * np.sin(2 * np.pi * 100 * TIME)
    + 0.3 * np.sin(2 * np.pi * 1500 * TIME),
    "blows": blows(),
}


def tracks_of(*rows, impacts=()):
    listeners = tuple(
        ListenerTrack(f"listener {k}", "hand.L", np.array(impacts).reshape(-1, 2))
        for k in range(len(rows))
    )
    return Tracks(listeners, RATE, np.array(rows))


def band_power(samples, low, high):
    spectrum = np.abs(np.fft.rfft(samples)) ** 2
    hertz = np.fft.rfftfreq(len(samples), 1 / RATE)
    return float(spectrum[(hertz >= low) & (hertz <= high)].sum())


@pytest.mark.parametrize("name", ["hjif", "wyvrn"])
@pytest.mark.parametrize("signal", SIGNALS)
def test_lost_power_of_waves(tmp_path, name, signal):
    source = SIGNALS[signal]
    written = registry.write(name, Export("one", tracks=tracks_of(source)), tmp_path)
    path = next(path for path in written.files if path.suffix in catalogue.readers())
    again = np.zeros(len(source))
    played = registry.read(path).channels[0].at_rate(RATE)[: len(source)]
    again[: len(played)] = np.clip(played, -1, 1)
    found = written.fidelity
    low, high = found.low, found.high
    assert found.kind is Kind.WAVE
    inside = band_power(source, low, high)
    lost = band_power(source - again, low, high) / inside
    assert found.lost_within == pytest.approx(lost, rel=0.1, abs=0.01)
    assert found.beyond == pytest.approx(1 - inside / band_power(source, 0, RATE), abs=0.01)
    assert found.level == pytest.approx(
        10 * np.log10(band_power(again, low, high) / inside), abs=0.2
    )
    assert any(f"from {low:g} to {high:g} Hz" in loss for loss in written.losses)


def test_a_known_error_is_measured_by_band():
    """A tone that is played at half its amplitude, and another that is left out."""
    tracks = tracks_of(0.4 * np.sin(2 * np.pi * 60 * TIME) + 0.2 * np.sin(2 * np.pi * 500 * TIME))
    measured = Comparison(tracks, Measures(Kind.WAVE, 5, 400))
    half = 0.2 * np.sin(2 * np.pi * 60 * TIME)
    for first in range(0, len(TIME), 999):
        part = slice(first, first + 999)
        measured.add(0, half[part][:: measured.thinning])
    found = measured.result()
    assert measured.thinning == 3
    assert found.lost == pytest.approx((0.2**2 + 0.2**2) / (0.4**2 + 0.2**2), abs=0.005)
    assert found.lost_within == pytest.approx(0.25, abs=0.005)
    assert found.beyond == pytest.approx(0.2**2 / (0.4**2 + 0.2**2), abs=0.005)
    assert found.level == pytest.approx(-6.02, abs=0.05)
    assert [(low, high) for low, high, _ in found.band_levels] == [(40, 80)]


@pytest.mark.parametrize("piece", [len(TIME), 2997])
@pytest.mark.parametrize("late", [0, 7, -12])
def test_late_onsets_are_measured(late, piece):
    """At a rate of the decoded signal with no whole number of samples in a millisecond, in one
    piece and in many."""
    tracks = tracks_of(blows(), impacts=[(t, 0.8) for t in np.arange(0, 6, 0.4)])
    measured = Comparison(tracks, Measures(Kind.WAVE))
    played = np.roll(blows(), late * RATE // 1000)
    for first in range(0, len(TIME), piece):
        part = slice(first, first + piece)
        measured.add(0, played[part][:: measured.thinning])
    assert measured.result().onset == pytest.approx(abs(late), abs=1)


def test_the_listener_who_loses_most_is_named():
    tracks = tracks_of(SIGNALS["tone"], SIGNALS["blows"])
    measured = Comparison(tracks, Measures(Kind.WAVE))
    for number, row in enumerate(tracks.samples):
        measured.add(number, (row if number == 0 else 0.5 * row)[:: measured.thinning])
    found = {listener.name: listener for listener in measured.result().listeners}
    assert list(found) == ["listener 1", "listener 0"]
    assert found["listener 1"].lost == pytest.approx(0.25, abs=0.01)
    assert found["listener 1"].level == pytest.approx(-6.02, abs=0.05)
    assert found["listener 0"].lost == pytest.approx(0, abs=0.001)
    assert found["listener 0"].level == pytest.approx(0, abs=0.05)


@pytest.mark.parametrize("loud", [1.0, 0.003])
def test_missing_and_invented_onsets_are_named(loud):
    """Of a listener beside a louder one, the third blow is left out, and one is played that was not
    there."""
    blow = blows()[: int(0.4 * RATE)]
    original, played = np.zeros(len(TIME)), np.zeros(len(TIME))
    for onset, own, other in ((0.5, 1, 1), (1.5, 1, 1), (2.5, 1, 0), (3.5, 1, 0.5), (4.5, 0, 1)):
        part = slice(int(onset * RATE), int(onset * RATE) + len(blow))
        original[part], played[part] = loud * own * blow, loud * other * blow
    tracks = tracks_of(SIGNALS["tone"], original)
    for kind in (Kind.WAVE, Kind.SPECTRUM):
        measured = Comparison(tracks, Measures(kind))
        for number, row in enumerate((SIGNALS["tone"], played)):
            measured.add(number, row[:: measured.thinning])
        found = {listener.name: listener for listener in measured.result().listeners}
        assert found["listener 0"].missing == found["listener 0"].invented == ()
        assert found["listener 1"].missing == pytest.approx((2.5,), abs=0.01)
        assert found["listener 1"].invented == pytest.approx((4.5,), abs=0.01)
        words = list(measured.result().sentences())
        assert any(line.startswith("onsets missing at listener 1: 2.") for line in words)
        assert any(line.startswith("onsets invented at listener 1: 4.") for line in words)
        assert any(line.startswith("by listener, most lost first: listener 1 ") for line in words)


def pulses(hertz):
    """A train of pulses as of a jackhammer, from half a period on, and their times."""
    since = (TIME + 0.5 / hertz) % (1 / hertz)
    return 0.5 * (since < 0.1 / hertz), np.arange(0.5, 6 * hertz) / hertz


@pytest.mark.parametrize("form", ["haptic", "ahap"])
@pytest.mark.parametrize("hertz", [5, 15, 30, 60])
def test_pulses_are_played_one_by_one(tmp_path, form, hertz):
    """Each as an emphasis or a transient within a millisecond, with the power of the train, 1 dB.
    Transients last 20 ms: 60 a second are a vibration, and the report says that all are missing."""
    train, times = pulses(hertz)
    options = WIDE if form == "haptic" else {}
    written = registry.write(form, Export("train", tracks=tracks_of(train)), tmp_path, options)
    parts = [registry.read(path).channels[0] for path in written.files if path.suffix == f".{form}"]
    bursts = np.unique([c.start for part in parts for c in part.carriers if c.end - c.start < 0.04])
    played = sum(np.pad(part.at_rate(RATE), (0, len(TIME)))[: len(TIME)] for part in parts)
    assert 10 * np.log10(np.var(played) / np.var(train)) == pytest.approx(0, abs=1)
    missing, count = written.fidelity.listeners[0].missing, round(6 * hertz)
    if form == "ahap" and hertz == 60:
        assert not len(bursts) and len(missing) == pytest.approx(count, abs=5)
        assert any(line.endswith(f"and {len(missing) - 4} more") for line in written.losses)
    else:
        np.testing.assert_allclose(bursts, times, atol=1.01e-3)
        assert missing == ()


@pytest.mark.parametrize("wave", ["noise", "tone", "low and high"])
def test_what_has_no_pulses_is_no_emphasis(tmp_path, wave):
    written = registry.write("haptic", Export("one", tracks=tracks_of(SIGNALS[wave])), tmp_path)
    assert not any("emphasis" in point for point in amplitudes(written.files[0]))


@pytest.mark.parametrize("hertz", [5, 15, 30, 60])
def test_a_hum_lacks_every_pulse_and_longer_pulses_none(hertz):
    """Of the same power; ten listeners who lack the same are named in one sentence."""
    train, times = pulses(hertz)
    power = np.var(train)
    hum = np.sqrt(2 * power) * np.sin(2 * np.pi * 260 * TIME)
    since = (TIME + 0.5 / hertz) % (1 / hertz)
    longer = (since < 0.01) * np.sqrt(200 * power / hertz) * np.sin(2 * np.pi * 200 * since)
    tracks = tracks_of(*[train] * 10)
    for wave, lacking in ((hum, len(times)), (longer, 0)):
        measured = Comparison(tracks, Measures(Kind.SPECTRUM))
        for number in range(10):
            measured.add(number, wave[:: measured.thinning])
        found = measured.result()
        for listener in found.listeners:
            assert len(listener.missing) == pytest.approx(lacking, abs=5 * bool(lacking))
        lines = [line for line in found.sentences() if "missing" in line]
        assert len(lines) == bool(lacking)


def test_a_steady_push_counts_in_no_level():
    """A tone on a constant of nearly the same power, of which only the tone is played."""
    for kind in (Kind.WAVE, Kind.SPECTRUM):
        measured = Comparison(tracks_of(0.2 + 0.6 * SIGNALS["tone"]), Measures(kind))
        measured.add(0, 0.6 * SIGNALS["tone"][:: measured.thinning])
        found = measured.result()
        assert abs(found.level) < 0.1 and (found.lost or 0) < 0.02 and found.beyond == 0


def test_silence_has_no_losses(tmp_path):
    for name in catalogue.formats():
        if name != "scene":
            assert (
                registry.write(name, Export("one", tracks=tracks_of(0 * TIME)), tmp_path).fidelity
                is None
            )


def test_levels_of_formats_without_waves(tmp_path):
    """Their strength is that of the sine with the same power."""
    for name in ("haptic", "ahap", "tact"):
        found = registry.write(
            name, Export("one", tracks=tracks_of(SIGNALS["tone"])), tmp_path
        ).fidelity
        assert abs(found.level) < 0.5, name


REBOUNDS = ((0.5, 0.9), (1.1, 0.5), (1.4, 0.25), (1.55, 0.12), (1.63, 0.06))
IN_A_ROW = tuple((0.5 + 0.01 * k, 0.3 + 0.05 * (k % 3)) for k in range(30))


@pytest.mark.parametrize("gain", [1.0, 1e-3])
@pytest.mark.parametrize("beside", [0.0, 0.05])
@pytest.mark.parametrize(("hertz", "decay"), [(60, 0.1), (80, 0.015), (150, 0.03), (300, 0.008)])
@pytest.mark.parametrize("blows", [REBOUNDS, IN_A_ROW])
def test_emphases_keep_the_level_and_the_onsets(tmp_path, blows, hertz, decay, beside, gain):
    """Blows alone or beside a tone, of a loud and of a quiet listener; the level is that of the
    energy of the file as it is read, above 1 Hz: blows in a row push steadily as well."""
    since = [np.maximum(TIME - time, 0) for time, _ in blows]
    waves = [
        strength * np.exp(-t / decay) * np.sin(2 * np.pi * hertz * t)
        for t, (_, strength) in zip(since, blows, strict=True)
    ]
    samples = gain * np.clip(sum(waves) + beside * np.sin(2 * np.pi * 60 * TIME), -1, 1)
    tracks = tracks_of(samples, impacts=[(time, gain * strength) for time, strength in blows])
    written = registry.write("haptic", Export("blows", tracks=tracks), tmp_path, WIDE)
    played = registry.read(written.files[0]).channels[0].at_rate(RATE)
    played = np.pad(played, (0, len(TIME)))[: len(TIME)]
    assert 10 * np.log10(
        band_power(played, 1, RATE) / band_power(samples, 1, RATE)
    ) == pytest.approx(0, abs=1)
    (listener,) = written.fidelity.listeners
    assert listener.level == pytest.approx(0, abs=1) and listener.missing == listener.invented == ()
    assert sum("emphasis" in point for point in amplitudes(written.files[0])) >= len(REBOUNDS)


def amplitudes(path):
    return json.loads(path.read_text())["signals"]["continuous"]["envelopes"]["amplitude"]


@pytest.mark.parametrize("form", ["haptic", "ahap", "tact"])
def test_the_steady_part_of_a_train_of_pulses_is_not_played(tmp_path, form):
    """Of pulses of a tenth of the period, a tenth of the power is steady; before the train begins,
    nothing plays."""
    train = 0.5 * (np.arange(len(TIME)) % 320 < 32) * (TIME >= 2.0)
    written = registry.write(form, Export("train", tracks=tracks_of(train)), tmp_path)
    played = registry.read(written.files[0]).channels[0].at_rate(RATE)
    settled = slice(3 * RATE, 5 * RATE)
    assert 10 * np.log10(np.mean(played[settled] ** 2) / np.var(train[settled])) == pytest.approx(
        0, abs=0.4
    )
    assert written.fidelity.level == pytest.approx(0, abs=0.4)
    assert np.abs(played[: int(1.9 * RATE)]).max(initial=0.0) < 1e-3


@pytest.mark.parametrize("form", ["haptic", "ahap"])
def test_quiet_listeners_keep_level_and_frequency(tmp_path, form):
    """What is 66 dB below full scale, and rises while its frequency does."""
    samples = 5e-4 * TIME / TIME[-1] * np.sin(2 * np.pi * (80 * TIME + 10 * TIME**2))
    written = registry.write(form, Export("quiet", tracks=tracks_of(samples)), tmp_path)
    assert written.fidelity.level == pytest.approx(0, abs=0.5)
    played = registry.read(written.files[0]).channels[0].at_rate(RATE)
    for begin in (2, 4):
        spectrum = np.abs(np.fft.rfft(played[begin * RATE : (begin + 1) * RATE] * np.hanning(RATE)))
        assert np.argmax(spectrum) == pytest.approx(80 + 20 * (begin + 0.5), abs=12)


@pytest.mark.parametrize("impacts", [(), ((0.5, 0.8),)])
def test_no_ahap_pattern_is_empty(tmp_path, impacts):
    """Of a silent listener, and of one who feels nothing but an impact, which is then the only
    file."""
    samples = np.where(
        (TIME >= 0.5) & (TIME < 0.51) & bool(impacts), 0.8 * np.sin(2 * np.pi * 200 * TIME), 0
    )
    written = registry.write(
        "ahap", Export("one", tracks=tracks_of(samples, impacts=impacts)), tmp_path
    )
    (path,) = written.files
    (event,) = (entry["Event"] for entry in json.loads(path.read_text())["Pattern"])
    assert event["EventType"] == ("HapticTransient" if impacts else "HapticContinuous")
    assert (event["EventParameters"][0]["ParameterValue"] > 0) == bool(impacts)


@pytest.mark.parametrize("answer", [True, False])
def test_a_file_is_replaced_only_with_consent(tmp_path, answer):
    asked = []
    export = Export("one", tracks=tracks_of(SIGNALS["noise"]))

    def consent(written):
        asked.append(written)
        return answer

    first = registry.write("wyvrn", export, tmp_path, {}, consent)
    assert first.files and not asked  # nothing was there to be replaced
    content = {path: path.read_bytes() for path in first.files}
    louder = Export("one", tracks=tracks_of(2 * SIGNALS["noise"]))
    second = registry.write("wyvrn", louder, tmp_path, {}, consent)
    assert len(asked) == 1 and asked[0].fidelity.lost > 0.25 and bool(second.files) == answer
    changed = {path for path in content if path.read_bytes() != content[path]}
    assert bool(changed) == answer
    assert {path for path in tmp_path.rglob("*") if path.is_file()} == set(content)
    faithful = Export("one", tracks=tracks_of(SIGNALS["tone"]))
    registry.write("hjif", faithful, tmp_path, {}, consent)
    assert len(asked) == 1 and asked[0].is_poor
    (again,) = registry.write("hjif", faithful, tmp_path, {}, consent).files or [None]
    assert (again is not None) == answer
    assert len(asked) == 2 and not asked[1].is_poor and asked[1].replaced == asked[1].files
