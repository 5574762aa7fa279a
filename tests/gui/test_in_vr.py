"""VR sessions judged by what an OpenXR runtime was called with (Monado with two simulated
controllers, 20 frames a second)."""

import json
import re
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

HERE = Path(__file__).parent
NUMBERS = re.compile(r"->(displayTime|duration|frequency|amplitude) = (\S+)")
LONGEST = 60_000_000  # ns
RATE = 8000


def read_log(folder: Path) -> list[tuple[str, dict[str, float]]]:
    """The runtime's calls in order: those of frames, haptics and sessions, with their numbers."""
    text = (folder.parent / "openxr.txt").read_text(errors="replace")
    wanted = ("xrEndFrame", "xrApplyHapticFeedback", "xrStopHapticFeedback", "xrDestroySession")
    calls = []
    for call in text.split("\nXrResult "):
        name = call.partition("\n")[0].strip()
        if name in wanted:
            numbers = {key: float(value) for key, value in NUMBERS.findall(call)}
            calls.append((name, numbers))
    return calls


@pytest.fixture(scope="module")
def runs():
    """What the scenarios left, by name: played once."""
    return {}


@pytest.fixture
def played(play, folder, runs):
    def played(name):
        if name not in runs:
            report, printed = play(HERE / f"scenarios/{name}.py", "vr")
            assert report["error"] is None, report["error"]
            assert not [line for line in printed.splitlines() if "Traceback" in line], printed
            data = json.loads((folder / name / f"{name}.json").read_text())
            runs[name] = report["seen"], data, read_log(folder)
        return runs[name]

    return played


def applied(data, log):
    """Of each call to vibrate: when it was made [s], its values as the runtime has them, and the
    time until the frame that followed, of the runtime's clock [s]."""
    begins = [number for number, (name, _) in enumerate(log) if name == "xrApplyHapticFeedback"]
    assert len(begins) == len(data["calls"])
    ours = np.array([call[2:] for call in data["calls"]])
    theirs = np.array(
        [[log[k][1][key] for key in ("amplitude", "frequency", "duration")] for k in begins]
    )
    assert np.allclose(ours[:, :2], theirs[:, :2], rtol=1e-5)
    return np.array([call[0] for call in data["calls"]]), theirs


def phase(data, name):
    """The times at which a mark and the next one were set."""
    marks = dict(data["marks"])
    later = [time for _, time in data["marks"] if time > marks[name]]
    return marks[name], min(later, default=np.inf)


def frames_of(data, log, name):
    """Of a track's calls: times from its start [s], values, the samples that were due since the
    call before, and the seconds that the frame of the session took that ended with the call."""
    times, values = applied(data, log)
    begin, end = phase(data, name)
    inside = (times > begin) & (times < end)
    times, values = times[inside] - data["sent"][name], values[inside]
    samples = np.array(data["tracks"][name])
    due = []
    for before, now in pairwise(times.tolist()):
        due.append(samples[max(round(before * RATE), 0) : max(round(now * RATE), 0)])
    turns = np.array(data["ticks"]) - data["sent"][name]
    here = np.array([np.abs(turns - time).argmin() for time in times])
    return times, values, due, turns[here] - turns[here - 1]


def test_all_that_a_session_is_for(played):
    seen, _, _ = played("vr")
    assert seen.pop("left after disabling") == {}
    assert all(seen.values()), seen


def test_a_call_per_frame_that_lasts_until_60_ms(played):
    """A Blender that no longer takes milliseconds for nanoseconds fails here."""
    _, data, log = played("vr")
    _, values = applied(data, log)
    assert values[:, 2].max() <= LONGEST
    assert values[:, 2].min() >= 20e6
    since = 0
    for name, _ in log:
        since = 0 if name == "xrEndFrame" else since + (name == "xrApplyHapticFeedback")
        assert since <= 2  # one for each hand


@pytest.mark.parametrize("name", ["steady", "swept"])
def test_levels_and_frequencies_arrive(played, name):
    _, data, log = played("vr")
    times, values, due, _ = frames_of(data, log, name)
    whole = (times[1:] > 0.2) & (times[1:] < 3.9)
    wanted = np.array([np.mean(2 * samples**2) if len(samples) else 0.0 for samples in due])[whole]
    called, lasted = values[1:, 0][whole] ** 2, np.diff(times)[whole]
    errors = [
        10 * np.log10((called * lasted)[k : k + 3].sum() / (wanted * lasted)[k : k + 3].sum())
        for k in range(1, len(called) - 2)
        if lasted[k - 1 : k + 3].max() < 0.06  # else Blender was busy
    ]
    assert len(errors) > 10, "Blender was too busy to be judged"
    print(name, "dB", np.round([min(errors), np.median(errors), max(errors)], 3), len(errors))
    assert np.abs(errors).max() < 0.5
    at = times[1:][whole] - 0.025
    off = np.abs(values[1:, 1][whole] - (150.0 if name == "steady" else 80 + 50 * at))
    print(name, "Hz", np.round([np.median(off), off.max()], 2))
    assert np.median(off) < 5.0


def test_blows_arrive_in_the_next_frame_with_their_peaks(played):
    _, data, log = played("vr")
    times, values, _, frames = frames_of(data, log, "blows")
    samples = np.array(data["tracks"]["blows"])
    delays, losses = [], []
    for onset in data["onsets"]:
        first = int(np.argmax((times > onset) & (values[:, 0] > 0.1)))
        if frames[first] > 0.1:  # Blender was busy
            continue
        delays.append(times[first] - onset - frames[first])
        peak = np.sqrt(2 * np.mean(samples[round(onset * RATE) :][:80] ** 2))
        losses.append(20 * np.log10(values[first : first + 3, 0].max() / peak))
    print("later than a frame [ms]", np.round(1000 * np.array(delays), 1))
    print("peaks [dB]", np.round(losses, 2))
    assert len(delays) >= 3, "Blender was too busy to be judged"
    assert max(delays) < 0.005
    assert np.abs(losses).max() < 3.0


def test_every_stop_calls_the_stop_action(played):
    _, data, log = played("vr")
    times, _ = applied(data, log)
    places = [k for k, (name, _) in enumerate(log) if name == "xrApplyHapticFeedback"]
    for name in ("rest", "undo", "disconnecting", "panic", "loading", "disable"):
        begin, end = phase(data, name)
        inside = np.flatnonzero((times > begin) & (times < end))
        following = [call for call, _ in log[places[inside[-1]] + 1 :]]
        assert following.index("xrStopHapticFeedback") <= 2, name


def test_hands_feel_and_disturb_nothing(played):
    seen, data, log = played("vr_hands")
    assert seen.pop("left after disabling") == {}
    assert all(seen.values()), seen
    times, _ = applied(data, log)
    asked = np.array(data["asked"])
    begin, end = phase(data, "felt")
    calls = times[(times > begin) & (times < end)]
    delay = [time - asked[asked < time].max() for time in calls]
    print("handler to call [ms]", np.round(1000 * np.percentile(delay, [50, 95]), 2))
    assert np.median(delay) < 0.015


def test_hands_drop_no_frame(played):
    _, data, _ = played("vr_hands")
    intervals = {"with": [], "without": []}
    for name, begin in data["marks"]:
        if name.split()[0] in intervals:
            _, end = phase(data, name)
            ticks = [tick for tick in data["ticks"] if begin + 0.5 < tick < end]
            intervals[name.split()[0]] += np.diff(ticks).tolist()
    for name, found in intervals.items():
        print(name, "[ms]", np.round(1000 * np.percentile(found, [25, 50, 90]), 1), len(found))
    assert np.median(intervals["with"]) < 1.1 * np.median(intervals["without"])
