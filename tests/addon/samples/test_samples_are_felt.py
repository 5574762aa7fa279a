"""Every sample is felt by those whom it is about, is seen by its camera, and goes back and forth
between the default and the paper's strategies without a trace.

What is felt is decided here by SciPy's periodogram and the published threshold, not by the
product's meters.
"""

import bpy
import numpy as np
import pytest
from bpy_extras.object_utils import world_to_camera_view
from haptic_tracing.addon.changes.suspension import suspended
from haptic_tracing.addon.session import session, timeline
from haptic_tracing.core.message import Cause
from haptic_tracing.core.scene.body import DEFAULT_LISTENERS
from haptic_tracing.core.scene.values import Settings, SourceKind
from haptic_tracing.sample_scenes import SAMPLES, build_sample
from scipy import signal

PARTS = {
    "jackhammer_bench": [(1, 12)],
    "hammer_nail": [(14, 24)],
    "fireplace": [(1, 12)],
    "dishwasher_kitchen": [(1, 12)],
    "rails": [(66, 76)],
    "domino_wall": [(1, 60)],
    "pile": [(1, 12)],
    "air_blast": [(26, 38)],
    "sliding_and_rolling": [(12, 40), (200, 225)],
    "kart": [(14, 30), (72, 84)],
    "kitchen": [(1, 12), (37, 48)],
    "boardwalk": [(12, 30), (78, 84)],
    "robot_cell": [(20, 30), (38, 50)],
    "mine_ride": [(860, 890), (2105, 2125)],
}
"""Frames in which something is felt."""
LARGE = ("domino_wall", "mine_ride")
"""Samples that take long to build."""
WINDOW = 0.25
"""Seconds over which skin sums up."""


def sensation(samples, rate):
    """Decibels above the threshold of ISO/IEC 23090-31, 50 (log(f / 550 + 1 - 250 / 550) / log(1 -
    250 / 550))^2 - 45 dB of full scale."""
    hertz, power = signal.periodogram(
        samples, rate, window="hann", detrend=False, scaling="density"
    )
    felt = (hertz >= 5) & (hertz <= 1000)
    threshold = 50 * (np.log(hertz[felt] / 550 + 1 - 250 / 550) / np.log(1 - 250 / 550)) ** 2 - 45
    # The density of a sine of amplitude 1 sums up to 1/2; full scale is its amplitude.
    energy = 2 * (power[:, felt] * 10 ** (-threshold / 10)).sum(axis=1) * hertz[1]
    return 10 * np.log10(np.maximum(energy, 1e-30))


def strongest(scene, first, last):
    """The highest level above the threshold that each listener reaches in frames, by body part; and
    their warnings."""
    steps = [step.result for step in timeline.steps(scene, first, last)]
    rate, parts = steps[-1].sample_rate, [item.body_part for item in steps[-1].listeners]
    samples = np.concatenate([result.block for result in steps if result.block is not None], axis=1)
    width = round(WINDOW * rate)
    ends = range(min(width, samples.shape[1]), samples.shape[1] + 1, width // 10)
    found = np.max([sensation(samples[:, max(end - width, 0) : end], rate) for end in ends], axis=0)
    strongest_of = dict.fromkeys(parts, -np.inf)
    for part, level in zip(parts, found, strict=True):
        strongest_of[part] = max(strongest_of[part], level)
    return strongest_of, [warning for result in steps for warning in result.warnings]


@pytest.mark.slow
@pytest.mark.parametrize("name", SAMPLES)
def test_those_whom_a_sample_is_about_feel_it_and_nothing_is_wrong(build, name):
    scene = build(name)
    found = dict.fromkeys(DEFAULT_LISTENERS, -np.inf)
    for part in PARTS[name]:
        levels, warnings = strongest(scene, *part)
        found |= {listener: max(found[listener], level) for listener, level in levels.items()}
        assert warnings == []
        assert session.problems_of(scene) == ()
    about = {
        listener
        for listener in found
        if {listener, listener.partition(".")[0]} & set(SAMPLES[name].about)
    }
    assert about
    assert {listener: round(found[listener], 1) for listener in about if found[listener] <= 0} == {}


@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=pytest.mark.slow) if name in LARGE else name for name in SAMPLES],
)
def test_camera_sees_all_listeners_and_sources(build, name):
    scene = build(name)
    bpy.context.window.scene = scene
    for _, frame in PARTS[name]:
        with suspended():
            scene.frame_set(frame)
        seen = [obj for obj in scene.objects if obj.haptics.listener.enabled]
        seen += [
            obj
            for obj in scene.objects
            if obj.haptics.source.enabled
            and obj.haptics.source.amplitude > 0
            and name != "mine_ride"
        ]
        for obj in seen:
            x, y, depth = world_to_camera_view(scene, scene.camera, obj.matrix_world.translation)
            assert 0 < x < 1 and 0 < y < 1 and depth > 0, (frame, obj.name)


@pytest.mark.slow
@pytest.mark.parametrize("name", SAMPLES)
def test_as_in_the_paper_is_one_switch_there_and_back(build, name):
    count = {"pile": 12, "domino_wall": 16}.get(name)
    scene = build(name, count)
    assert scene.haptics.strategy == "best_path"
    _, frame = PARTS[name][0]
    found = []
    for strategy in ("best_path", "as_in_the_paper", "best_path"):
        scene.haptics.strategy = strategy
        scene.frame_set(frame)
        result = session.result_of(scene)
        found.append((result.propagation.strategy, result.propagation.gain))
        if strategy == "as_in_the_paper":
            warnings = result.propagation.warnings
    (default, gains), (paper, sums), back = found
    assert set(default) <= {"best_path"}
    assert paper == tuple(
        "as_in_the_paper" if source.kind is SourceKind.PERSISTENT else "best_path"
        for source in result.sources
    )
    assert back[0] == default and (back[1] == gains).all()
    # A sum has the best path in it, unless that is weaker or longer than the limits; a search that
    # ended before it came to a listener says so.
    connections = np.full(gains.shape, np.inf)
    for pair, nodes in result.propagation.best_path.items():
        connections[pair] = len(nodes) - 1
    limits = Settings()
    is_summed = (gains >= limits.threshold) & (connections <= limits.max_connections)
    if any(item.cause is Cause.SUM_BUDGET for item in warnings):
        is_summed &= sums > 0
    assert (sums >= gains * (1 - 1e-12))[is_summed].all()


def test_every_sample_is_about_somebody():
    names = {listener.split(".")[0] for listener in DEFAULT_LISTENERS} | set(DEFAULT_LISTENERS)
    assert all(set(sample.about) <= names and sample.about for sample in SAMPLES.values())
    with pytest.raises(ValueError, match="unknown"):
        build_sample("pyramid")
