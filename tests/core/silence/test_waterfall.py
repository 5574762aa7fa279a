"""The waterfall from a source's amplitude to a listener's level: its terms against closed forms and
independent sums, on random scenes."""

import math
from dataclasses import replace

import numpy as np
import pytest
from haptic_tracing.core.contacts.contact_set import ContactSet
from haptic_tracing.core.diagnosis.waterfall import waterfall
from haptic_tracing.core.render.history import still_samples
from haptic_tracing.core.scene.functions import Exponential, Spectrum
from haptic_tracing.core.scene.values import (
    Contact,
    HapticObject,
    HapticScene,
    Listener,
    Mode,
    Settings,
    Source,
)
from haptic_tracing.core.signals import Sine
from haptic_tracing.core.tracer import Frame, Tracer

SECONDS = 0.25
NEPER = 20 / math.log(10)
DECAYS = (0.0, 0.1, 0.3, 0.6, 1.1, 1.7)


def decibels(factor):
    return 20 * math.log10(factor)


def traced(scene):
    names = sorted(item.name for item in scene.objects)
    contacts = ContactSet.from_contacts(scene.contacts, {name: k for k, name in enumerate(names)})
    frame = Frame(
        1, 0.0, scene.objects, scene.sources, scene.listeners, scene.settings, contacts=contacts
    )
    return Tracer().step(frame)


def level_of(result, column):
    """RMS of the rendered samples without their mean, in decibels."""
    samples = still_samples(result, SECONDS)[column]
    return decibels(float(np.std(samples))) if samples.any() else -math.inf


def fall_of(result, settings, row=0, column=0):
    return waterfall(result, settings.mode, row, column, level_of(result, column), SECONDS)


def total(fall):
    return (
        fall.amplitude
        - sum(hop.loss for hop in fall.hops)
        + fall.others
        + fall.listener_gain
        + fall.signal
        + fall.mix
    )


BEST = Settings(strategy="best_path")


def chain(settings=BEST, spectrum=None, sources=(("drill", 0.5, 60.0),), **listener):
    """Ground and bench, 2 m and 1 m long with a decay of 0.2 and 1.5 per metre; a listener at the
    far end of the bench."""
    objects = tuple(
        HapticObject(name, 0.0, 1.0, Exponential(alpha=alpha, spectrum=spectrum or Spectrum()))
        for name, alpha in (("ground", 0.2), ("bench", 1.5))
    )
    return HapticScene(
        objects,
        (Contact(("ground", "bench"), ((2, 0, 0), (2, 0, 0))),),
        tuple(
            Source(name, "ground", (0, 0, 0), amplitude, signal=Sine(f))
            for name, amplitude, f in sources
        ),
        (Listener("skin", "bench", (3, 0, 0), **listener, radius=0.0),),
        settings,
    )


def random_scene(seed, settings, banded):
    """Up to eight objects with contacts anywhere, tones of several frequencies, listeners of all
    kinds of mixing."""
    random = np.random.default_rng(seed)
    count = int(random.integers(2, 9))

    def place():
        return tuple(random.uniform(-2, 2, 3).tolist())

    def one():
        return f"o{random.integers(count)}"

    spectrum = Spectrum(band_decays=DECAYS) if banded else Spectrum()
    objects = tuple(
        HapticObject(
            f"o{k}", 0.1, 0.9, Exponential(alpha=float(random.uniform(0, 1)), spectrum=spectrum)
        )
        for k in range(count)
    )
    pairs = [random.choice(count, 2, replace=False) for _ in range(2 * count)]
    contacts = tuple(Contact((f"o{a}", f"o{b}"), (place(), place())) for a, b in pairs)
    sources = tuple(
        Source(
            f"s{k}",
            one(),
            place(),
            float(random.uniform(0.01, 1)),
            signal=Sine(float(random.uniform(20, 400))),
            priority=float(k),
        )
        for k in range(3)
    )
    listeners = tuple(
        Listener(
            f"l{k}",
            one(),
            place(),
            gain=float(random.uniform(0.2, 3)),
            mixing=("cumulative", "weighted", "strongest", "power")[k],
            limiter=bool(k % 2),
            radius=0.0,
        )
        for k in range(4)
    )
    return HapticScene(objects, contacts, sources, listeners, settings)


def test_every_row_of_a_tone_on_a_chain_has_its_closed_form():
    scene = chain(gain=1.5)
    fall = fall_of(traced(scene), scene.settings)
    assert fall.amplitude == pytest.approx(decibels(0.5))
    assert [(hop.object, hop.distance) for hop in fall.hops] == [
        ("ground", pytest.approx(2.0)),
        ("bench", pytest.approx(1.0)),
    ]
    assert [hop.loss for hop in fall.hops] == pytest.approx([0.4 * NEPER, 1.5 * NEPER])
    assert fall.gain == pytest.approx(-1.9 * NEPER)
    assert fall.others == pytest.approx(0.0, abs=1e-9)
    assert fall.listener_gain == pytest.approx(decibels(1.5))
    assert fall.signal == pytest.approx(decibels(math.sqrt(0.5)), abs=0.01)  # 15 periods of a sine
    assert fall.mix == pytest.approx(0.0, abs=1e-9)
    assert fall.level == pytest.approx(
        decibels(0.5 * math.exp(-1.9) * 1.5 * math.sqrt(0.5)), abs=0.01
    )
    assert total(fall) == pytest.approx(fall.level, abs=1e-9)


def test_other_sources_add_their_power():
    scene = chain(sources=(("drill", 0.3, 60.0), ("fan", 0.2, 100.0)))
    result = traced(scene)
    assert fall_of(result, scene.settings, 0).mix == pytest.approx(
        10 * math.log10(1 + (0.2 / 0.3) ** 2), abs=0.01
    )
    assert fall_of(result, scene.settings, 1).mix == pytest.approx(
        10 * math.log10(1 + (0.3 / 0.2) ** 2), abs=0.01
    )


def test_ceilings_and_the_weights_of_bands_have_rows_of_their_own():
    loud = chain(sources=(("drill", 1.0, 60.0),), gain=10.0, s_max=0.25)
    assert fall_of(traced(loud), loud.settings).mix < -3
    banded = chain(spectrum=Spectrum(band_decays=DECAYS))
    fall = fall_of(traced(banded), banded.settings)
    assert abs(fall.others) > 0.01  # the filters of the bands overlap
    assert fall.mix == pytest.approx(0.0, abs=0.01)


@pytest.mark.parametrize("mode", ["MD", "MN", "SD"])
def test_modes_without_objects_have_only_a_gain(mode):
    scene = chain(Settings(mode=mode))
    fall = fall_of(traced(scene), scene.settings)
    assert fall.gain == pytest.approx(0.0 if mode == "MN" else -0.2 * 3.0 * NEPER)
    assert bool(fall.hops) is (mode == "SD")
    assert total(fall) == pytest.approx(fall.level, abs=1e-9)


@pytest.mark.parametrize("banded", [False, True], ids=["plain", "bands"])
@pytest.mark.parametrize("strategy", ["best_path", "as_in_the_paper"])
def test_rows_add_up_on_random_scenes(strategy, banded):
    found = paths = 0
    for seed in range(12):
        scene = random_scene(seed, Settings(strategy=strategy, threshold=0.0), banded)
        result = traced(scene)
        levels = [level_of(result, column) for column in range(len(scene.listeners))]
        for row, column in np.argwhere(result.amplitudes > 0).tolist():
            fall = waterfall(result, scene.settings.mode, row, column, levels[column], SECONDS)
            found += 1
            assert total(fall) == pytest.approx(levels[column], abs=1e-9)
            assert fall.gain == pytest.approx(
                decibels(result.amplitudes[row, column] / scene.sources[row].amplitude), abs=1e-9
            )
            if not banded:
                assert fall.gain == pytest.approx(
                    decibels(result.propagation.gain[row, column]), abs=1e-9
                )
                if strategy == "best_path":
                    assert fall.others == pytest.approx(0.0, abs=1e-6)
                if strategy == "as_in_the_paper":
                    assert fall.others >= -1e-6
                    paths += fall.others > 1e-3
    assert found > 30 and (strategy != "as_in_the_paper" or banded or paths > 5)


def test_a_single_source_alone_leaves_nothing_to_the_mix():
    """Whatever its way: the level is that of its own signal, so all rows before are the whole of
    what is played."""
    for seed in range(8):
        scene = random_scene(seed, Settings(), banded=bool(seed % 2))
        alone = replace(
            scene,
            sources=(replace(scene.sources[0], amplitude=0.2),),
            listeners=(replace(scene.listeners[0], gain=1.3),),
        )
        result = traced(alone)
        if result.amplitudes[0, 0] > 0:
            assert fall_of(result, alone.settings).mix == pytest.approx(0.0, abs=1e-6)


def test_silence():
    deaf = chain(gain=0.0)
    fall = fall_of(traced(deaf), deaf.settings)
    assert (fall.listener_gain, fall.level, fall.mix) == (-math.inf, -math.inf, 0.0)
    assert fall.gain == pytest.approx(-1.9 * NEPER)
    assert Mode.HT is deaf.settings.mode
