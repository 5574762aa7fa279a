"""Runs: impacts, samples and levels of steps, against closed forms and against the tracer that
Blender's frames use."""

from __future__ import annotations

import math
from itertools import pairwise

import haptic_tracing as ht
import numpy as np
import pytest

G = 9.81
STILL = (1.0, 0.0, 0.0, 0.0)


def floor_and_crate(**parts):
    ground = {"name": "ground", "kappa": 0.1, "rho": 0.9, "motion": "static", "shape": {"type": "box", "size": [10, 10, 1]},
              "pose": {"position": [0, 0, -0.5]}}  # fmt: skip
    crate = {"name": "crate", "kappa": 0.1, "rho": 0.9, "mass": 5.0, "shape": {"type": "box", "size": [1, 1, 1]},
             "pose": {"position": [0, 0, 0.5]}}  # fmt: skip
    drill = {"name": "drill", "object": "ground", "position": [3, 0, 0]}
    hand = {"name": "hand", "object": "crate", "position": [0, 0, 1]}
    return ht.Scene(
        **{"objects": [ground, crate], "sources": [drill], "listeners": [hand], **parts}
    )


def drop(run, height, frame_rate, seconds, **more):
    """The steps of a fall from ``height``."""
    for frame in range(round(seconds * frame_rate)):
        time = frame / frame_rate
        z = max(height - G / 2 * time**2, 0.0) + 0.5
        yield run.step(time, {"crate": (0, 0, z, *STILL)}, **more)


@pytest.mark.parametrize("frame_rate", [30, 60, 90])
@pytest.mark.parametrize("height", [0.5, 2.0])
def test_a_dropped_crate_hits_once_when_and_as_it_must(height, frame_rate):
    blows = [
        blow
        for step in drop(ht.open(floor_and_crate()), height, frame_rate, 1.0)
        for blow in step.impacts
    ]
    (blow,) = blows
    assert blow.objects == ("ground", "crate")
    assert blow.time == pytest.approx(math.sqrt(2 * height / G), abs=2e-3)
    assert blow.energy == pytest.approx(5.0 * G * height, rel=0.03)
    assert blow.gains["hand"] > 0


@pytest.mark.parametrize("motion", ["dynamic", "kinematic"])
def test_a_blow_of_what_physics_does_not_move_is_estimated(motion):
    ground, crate = floor_and_crate().document["objects"]
    run = ht.open(floor_and_crate(objects=[ground, crate | {"motion": motion}]))
    (blow,) = [blow for step in drop(run, 0.5, 60, 1.0) for blow in step.impacts]
    assert blow.estimated == (motion == "kinematic")


def test_an_impact_before_time_0_is_felt():
    run = ht.open(floor_and_crate())
    steps = [
        run.step(
            frame / 60 - 5, {"crate": (0, 0, max(1 - G / 2 * (frame / 60) ** 2, 0) + 0.5, *STILL)}
        )
        for frame in range(40)
    ]
    (blow,) = [blow for step in steps for blow in step.impacts]
    assert blow.time == pytest.approx(math.sqrt(2 / G) - 5, abs=2e-3)


def test_blocks_are_contiguous():
    steps = list(drop(ht.open(floor_and_crate(), sample_rate=8000), 1.0, 59.94, 1.0))
    assert steps[0].block.shape == (1, 0)
    for before, after in pairwise(steps[1:]):
        assert after.first_sample == before.first_sample + before.block.shape[1]
    assert steps[-1].first_sample + steps[-1].block.shape[1] == math.ceil(
        steps[-1].time * 8000 - 1e-6
    )


def test_the_level_of_a_tone_is_its_rms():
    """A tone of amplitude 0.5 over a path of gain g has the level 20 lg(0.5 g / sqrt 2); its share
    of the mix is the gain of the path."""
    function = {"function": "exponential", "alpha": 0.2}
    bar = {"name": "bar", "kappa": 0.1, "rho": 0.9, "propagation": function}
    tone = {
        "name": "tone",
        "object": "bar",
        "amplitude": 0.5,
        "signal": {"signal": "sine", "frequency": 80},
    }
    run = ht.open(ht.Scene(objects=[bar], sources=[tone | {"position": [0, 0, 0]}], listeners=[
        {"name": "hand", "object": "bar", "position": [2, 0, 0], "gain": 2.0, "radius": 0}
    ]))  # fmt: skip
    gain = math.exp(-0.4)
    for frame in range(60):
        step = run.step(frame / 50)
    assert step.levels["hand"].gains == {"tone": pytest.approx(gain)}
    assert step.levels["hand"].level == pytest.approx(
        20 * math.log10(0.5 * gain * 2.0 / math.sqrt(2)), abs=0.01
    )
    assert run.step(60 / 50, sources={"tone": {"playing": False}}).levels["hand"].gains == {
        "tone": 0.0
    }
    for frame in range(61, 90):
        step = run.step(frame / 50)
    assert step.levels["hand"].level is None and step.levels["hand"].margin is None
    assert run.step(90 / 50, sources={"tone": {"playing": True, "amplitude": 0.25}}).levels[
        "hand"
    ].gains["tone"] == pytest.approx(gain)


def test_sources_and_listeners_move_with_their_objects():
    run = ht.open(floor_and_crate())
    near = run.step(0.0).levels["hand"].gains["drill"]
    turned = (
        run.step(0.1, {"crate": (3, 0, 0.5, math.sqrt(0.5), 0, 0, math.sqrt(0.5))})
        .levels["hand"]
        .gains["drill"]
    )
    alone = run.step(0.2, {"crate": (3, 0, 5, *STILL)}).levels["hand"].gains["drill"]
    assert turned > near > alone == 0.0
    there = (
        run.step(0.3, {"crate": (0, 0, 0.5, *STILL)}, source_positions={"drill": (0.0, 0.0, 0.0)})
        .levels["hand"]
        .gains["drill"]
    )
    assert there == pytest.approx(turned, rel=1e-6)


def test_a_jump_in_time_begins_anew_without_impacts():
    run = ht.open(floor_and_crate())
    for frame in range(10):
        run.step(frame / 60, {"crate": (0, 0, 3 - frame * 0.2, *STILL)})
    assert run.step(5.0, {"crate": (0, 0, 0.5, *STILL)}).impacts == ()
    assert run.step(4.0, {"crate": (0, 0, 0.5, *STILL)}).block.shape == (1, 0)
    with pytest.raises(ValueError, match="time"):
        run.step(4.0)
    with pytest.raises(ValueError, match="time"):
        run.step(math.nan)


def test_contacts_and_impacts_of_the_caller_replace_the_search():
    run = ht.open(floor_and_crate())
    far = {"crate": (0, 0, 1.2, *STILL)}  # 0.7 m above the ground
    touching = [{"objects": ["ground", "crate"], "positions": [[0, 0, 0], [0, 0, 0]]}]
    hit = [
        {"objects": ["crate", "ground"], "position": [0, 0, 0], "time": 0.015, "normal_speed": 4.0}
    ]
    run.step(0.0, far, contacts=touching)
    step = run.step(0.02, far, contacts=touching, impacts=hit)
    (blow,) = step.impacts
    assert (blow.objects, blow.time) == (("ground", "crate"), 0.015)
    assert blow.energy == pytest.approx(5.0 * 16 / 2)  # the ground does not move
    assert step.levels["hand"].gains["drill"] > 0
    assert blow.gains["hand"] > 0
    assert np.abs(run.step(0.04, far, contacts=touching).block).max() > 0
    found = ht.open(floor_and_crate())
    found.step(0.0)
    assert [
        blow.energy for blow in found.step(0.02, impacts=[hit[0] | {"normal_speed": 0.1}]).impacts
    ] == []  # below E_min
    with pytest.raises(ValueError, match="impacts/0/objects/1: there is no object 'moon'"):
        run.step(
            0.06, impacts=[{"objects": ["ground", "moon"], "position": [0, 0, 0], "energy": 50}]
        )


def test_what_is_added_and_removed_is_heard_and_gone():
    run = ht.open(floor_and_crate())
    run.step(0.0)
    box = {"name": "box", "kappa": 0.1, "rho": 0.9, "mass": 1.0, "shape": {"type": "box", "size": [1, 1, 1]},
           "pose": {"position": [0, 0, 1.5]}}  # fmt: skip
    run.add(object=box)
    run.add(listener={"name": "foot", "object": "box", "position": [0, 0, 2]})
    step = run.step(0.02)
    assert step.listeners == ("hand", "foot")
    assert 0 < step.levels["foot"].gains["drill"] < step.levels["hand"].gains["drill"]
    with pytest.raises(ValueError, match="there is an object 'box' already"):
        run.add(object=box)
    run.remove(object="crate")
    step = run.step(0.04)
    assert step.listeners == ("foot",)
    assert step.levels["foot"].gains["drill"] == 0.0
    run.replace(object={**box, "pose": {"position": [0, 0, 0.5]}})
    assert run.step(0.06).levels["foot"].gains["drill"] > 0.0
    with pytest.raises(ValueError, match="no source 'crate'"):
        run.remove(source="crate")


@pytest.mark.parametrize("change", ["add", "remove", "both"])
def test_what_comes_and_goes_far_away_changes_no_blow_and_no_sample(change):
    def far(number):
        return {"name": f"far {number}", "kappa": 0.1, "rho": 0.9, "mass": 1.0,
                "shape": {"type": "sphere", "radius": 0.2}, "pose": {"position": [50, number, 9]}}  # fmt: skip

    quiet, busy = ht.open(floor_and_crate()), ht.open(floor_and_crate())
    for number in range(60):
        busy.add(object=far(number))
    blows = []
    for frame, expected in enumerate(drop(quiet, 0.5, 60, 1.0)):
        if change != "remove":
            busy.add(object=far(60 + frame))
        if change != "add":
            busy.remove(object=f"far {frame}")
        time = frame / 60
        z = max(0.5 - G / 2 * time**2, 0.0) + 0.5
        step = busy.step(time, {"crate": (0, 0, z, *STILL)})
        assert [blow.time for blow in step.impacts] == [blow.time for blow in expected.impacts]
        assert step.block == pytest.approx(expected.block, abs=1e-9)
        blows += step.impacts
    assert len(blows) == 1


def set_by_pose(run, crate, pose):
    return {"poses": {"crate": pose}}


def set_by_replace(run, crate, pose):
    run.replace(object={**crate, "pose": {"position": pose[:3], "rotation": pose[3:]}})
    return {}


def set_by_remove_and_add(run, crate, pose):
    run.remove(object="crate")
    run.add(object={**crate, "pose": {"position": pose[:3], "rotation": pose[3:]}})
    return {}


@pytest.mark.parametrize("way", [set_by_pose, set_by_replace, set_by_remove_and_add])
def test_a_crate_that_is_set_onto_the_ground_makes_no_blow_and_falls_again(way):
    """From 5 m above, or from a place that no motion leads from."""
    run = ht.open(floor_and_crate())
    _, crate = floor_and_crate().document["objects"]
    for frame in range(10):
        run.step(frame / 60, {"crate": (0, 0, 5.5 - G / 2 * (frame / 60) ** 2, *STILL)})
    step = run.step(10 / 60, **way(run, crate, (0, 0, 0.5, *STILL)))
    assert step.impacts == ()
    for frame in range(11, 20):
        assert run.step(frame / 60, {"crate": (0, 0, 0.5, *STILL)}).impacts == ()
    more = way(run, crate, (0, 0, 2.5, *STILL))
    blows = list(run.step(20 / 60, **more).impacts)
    for frame in range(1, 60):
        z = max(2.0 - G / 2 * (frame / 60) ** 2, 0.0) + 0.5
        blows += run.step((20 + frame) / 60, {"crate": (0, 0, z, *STILL)}).impacts
    (blow,) = blows
    assert blow.time == pytest.approx(20 / 60 + math.sqrt(2 * 2.0 / G), abs=2e-3)
    assert blow.energy == pytest.approx(5.0 * G * 2.0, rel=0.03)


def test_what_is_faster_than_100_m_s_all_the_time_still_hits():
    """From the step after that in which it came so fast."""
    run = ht.open(floor_and_crate())
    speed = 120.0
    blows = []
    for frame in range(60):
        z = max(20.0 - speed * frame / 60, 0.0) + 0.5
        blows += run.step(frame / 60, {"crate": (0, 0, z, *STILL)}).impacts
    (blow,) = blows
    assert blow.time == pytest.approx(20.0 / speed, abs=2e-3)
    assert blow.energy == pytest.approx(5.0 * speed**2 / 2, rel=0.03)


def test_contacts_of_the_caller_may_follow_found_ones_while_a_blow_sounds():
    """Objects without a shape are among those that its impacts number, but are no bodies."""
    air = {"name": "air", "kappa": 0.1, "rho": 0.9}
    ground, crate = floor_and_crate().document["objects"]
    run = ht.open(floor_and_crate(objects=[air, ground, crate]))
    touching = [{"objects": ["ground", "crate"], "positions": [[0, 0, 0], [0, 0, 0]]}]
    steps = list(drop(run, 0.5, 60, 0.35))
    assert steps[-1].impacts or steps[-2].impacts
    ends = [run.step(0.36, contacts=touching), run.step(0.37), run.step(0.38, contacts=touching)]
    assert all(
        any(name.startswith("impact of ground and crate") for name in end.levels["hand"].gains)
        for end in ends
    )


def test_a_source_with_triggers_plays_once_when_it_is_asked_to():
    click = {"name": "click", "object": "crate", "position": [0, 0, 1], "triggers": []}
    run = ht.open(floor_and_crate(sources=[click]))
    assert all(run.step(frame / 50).levels["hand"].level is None for frame in range(5))
    run.play("click")
    assert np.abs(run.step(0.1).block).max() > 0.1
    for frame in range(6, 150):
        step = run.step(frame / 50)
    assert step.levels["hand"].level is None
    with pytest.raises(ValueError, match="plays all the time"):
        ht.open(floor_and_crate()).play("drill")


def test_after_stop_nothing_sounds_and_no_impact_is_invented():
    run = ht.open(floor_and_crate())
    assert any(step.impacts for step in drop(run, 1.0, 60, 0.5))
    run.stop()
    step = run.step(100.0, {"crate": (0, 0, 0.5, *STILL)})
    assert step.impacts == () and step.block.shape == (1, 0)


def test_listed_contacts_hold_while_their_objects_rest():
    listed = [{"objects": ["ground", "crate"], "positions": [[4, 0, 0], [4, 0, 0]]}]
    run = ht.open(floor_and_crate(contacts=listed))
    given = run.step(0.0).levels["hand"].gains["drill"]
    assert given == pytest.approx(floor_and_crate(contacts=listed).gains()["drill", "hand"])
    moved = run.step(0.1, {"crate": (0, 0, 0.5, *STILL)}).levels["hand"].gains["drill"]
    assert moved == pytest.approx(floor_and_crate().gains()["drill", "hand"])
    assert moved != pytest.approx(given, rel=0.01)


def test_a_source_that_comes_in_the_place_of_another_has_its_own_amplitude_and_plays():
    run = ht.open(floor_and_crate())
    (drill,) = floor_and_crate().document["sources"]
    run.step(0.0, sources={"drill": {"amplitude": 0.5, "playing": False}})
    run.remove(source="drill")
    run.add(source={**drill, "amplitude": 0.25})
    quiet = run.step(1.0).levels["hand"].level
    run.replace(source={**drill, "amplitude": 1.0})
    assert run.step(2.0).levels["hand"].level == pytest.approx(quiet + 20 * math.log10(4), abs=1e-3)


MISTAKES = [
    ({"sources": {"dril": {"playing": True}}}, "sources/dril"),
    ({"sources": {"drill": {"amplitude": 2}}}, "sources/drill/amplitude"),
    ({"source_positions": {"hand": (0, 0, 0)}}, "source_positions/hand"),
    ({"listener_positions": {"hand": (0, 0)}}, "listener_positions/hand"),
    ({"listener_positions": {"hand": (0, 0, math.nan)}}, "listener_positions/hand"),
    (
        {"contacts": [{"objects": ["crate", "wall"], "positions": [[0, 0, 0]]}]},
        "contacts/0/objects/1",
    ),
    (
        {"contacts": [{"objects": ["crate", "ground"], "positoins": [[0, 0, 0]]}]},
        "contacts/0/positoins",
    ),
    ({"impacts": [{"objects": ["crate", "ground"], "position": [0, 0, 0]}]}, "impacts/0"),
]


@pytest.mark.parametrize("mistake, place", MISTAKES)
def test_a_step_that_is_refused_changes_nothing(mistake, place):
    refused, other = ht.open(floor_and_crate()), ht.open(floor_and_crate())
    for run in (refused, other):
        run.step(0.0)
    with pytest.raises(ValueError) as error:
        refused.step(0.05, {"crate": (0, 0, 3, *STILL)}, **mistake)
    assert str(error.value).startswith(place)
    for run in (refused, other):
        run.step(0.1)
    np.testing.assert_array_equal(refused.step(0.2).block, other.step(0.2).block)
    assert refused.step(0.3).levels["hand"].gains["drill"] > 0  # it still stands on the ground


def test_a_misspelt_setting_is_named():
    with pytest.raises(ValueError, match=r"settings/treshold: .*did you mean 'threshold'"):
        floor_and_crate().with_settings(treshold=0.1)


def test_a_time_that_is_no_number_is_named():
    with pytest.raises(ValueError, match=r"^time: must be a finite number"):
        ht.open(floor_and_crate()).step("0")


def falls_and_bounces(frame_rate, seconds):
    """Times and heights of a crate that is thrown up every half second."""
    for frame in range(round(seconds * frame_rate)):
        time = frame / frame_rate
        up = (time % 0.5) - 0.25
        yield time, (0, 0, 0.5 + G / 2 * (0.25**2 - up**2), *STILL)


@pytest.mark.parametrize("merged", [2, 5, 13])
def test_steps_that_are_answered_together_have_every_blow_and_sample(merged):
    """A group's answer has the blows that its steps have alone, and the state of its last step; its
    samples are those since the last answer."""
    quiet = {"impacts": True, "least_energy": 1.0, "full_energy": 100.0}
    alone, together = (ht.open(floor_and_crate(rules=quiet)) for _ in range(2))
    blows, told, steps, groups = [], [], [], []
    for number, (time, pose) in enumerate(falls_and_bounces(60, 3.0)):
        steps.append(alone.step(time, {"crate": pose}))
        blows += steps[-1].impacts
        together.follow(time, {"crate": pose})
        if number % merged == 0:
            groups.append(together.answer())
            told += groups[-1].impacts
            assert groups[-1].levels["hand"].gains["drill"] == pytest.approx(
                steps[-1].levels["hand"].gains["drill"]
            )
    assert len(blows) >= 4
    late = groups[-1].time
    assert [(blow.time, blow.objects, blow.energy) for blow in told] == [
        (blow.time, blow.objects, blow.energy) for blow in blows if blow.time <= late
    ]
    for before, after in pairwise(groups[1:]):
        assert after.first_sample == before.first_sample + before.block.shape[1]
    assert groups[0].block.shape[1] == 0 == groups[1].first_sample


def test_a_beginning_that_is_not_answered_still_begins_the_samples():
    run = ht.open(floor_and_crate(), sample_rate=8000)
    run.follow(3.0)
    run.follow(3.1)
    step = run.answer()
    assert (step.first_sample, step.block.shape[1]) == (0, 800)
    with pytest.raises(ValueError, match="no step"):
        run.answer()


def test_objects_stay_until_what_was_followed_is_answered():
    run = ht.open(floor_and_crate())
    run.follow(0.0)
    with pytest.raises(ValueError, match="answer"):
        run.remove(object="crate")
    run.answer()
    run.remove(object="crate")
    assert run.objects == ("ground",)


@pytest.mark.parametrize("origin", [-3600.0, 0.0, 1e6, 1.7e9])
def test_any_clock_gives_the_same_answers(origin):
    """Seconds since the start, an uptime of 11 days, and Unix time, at a rate that all of them hold."""
    click = {"name": "click", "object": "crate", "position": [0, 0, 1], "triggers": []}
    scene = floor_and_crate(sources=[click])
    run, reference = ht.open(scene), ht.open(scene)
    blows = []
    for k in range(40):
        if k == 30:
            run.play("click")
            reference.play("click")
        pose = {"crate": (0, 0, max(1 - G / 2 * (k / 64) ** 2, 0.0) + 0.5, *STILL)}
        step, same = run.step(origin + k / 64, pose), reference.step(k / 64, pose)
        assert (step.first_sample, step.block.shape) == (same.first_sample, same.block.shape)
        assert np.abs(step.block - same.block).max(initial=0.0) < 1e-3
        blows += zip(step.impacts, same.impacts, strict=True)
    ((blow, other),) = blows
    assert blow.time - origin == pytest.approx(other.time, abs=1e-6)


def test_a_clock_that_jumps_and_a_run_of_weeks_go_on():
    run = ht.open(floor_and_crate())
    run.step(0.0)
    assert run.step(1.7e9).block.shape[1] == 0
    assert run.step(1.7e9 + 1 / 64).block.shape[1] == 125
    run._first = 1.7e9 - 1e6  # as if it had begun 11.6 days ago
    anew = run.step(1.7e9 + 2 / 64)
    assert (anew.first_sample, anew.block.shape[1]) == (0, 0)


def test_a_play_is_not_repeated_where_time_begins_anew():
    click = {"name": "click", "object": "crate", "position": [0, 0, 1], "triggers": []}
    run = ht.open(floor_and_crate(sources=[click]))
    for k in range(30):
        if k == 5:
            run.play("click")
        run.step(k / 60)
    assert not run.step(0.0).levels["hand"].gains
    assert not any(run.step((k + 1) / 60).block.any() for k in range(30))
    run.play("click")
    run.step(9.0)  # anew; what was asked for before it is carried
    assert run.step(9.02).block.any()


POST = {"name": "post", "kappa": 0.1, "rho": 0.9, "pose": {"position": [5, 0, 0]}}
"""An object without a shape."""


@pytest.mark.parametrize("shaped", [[], ["ground", "crate"], ["crate"]])
def test_objects_without_a_shape_stand_beside_others(shaped):
    """Listeners, listed contacts and the engine's blows are the same for objects with and without
    shapes: the gain of an exponential function is that of its distance."""
    loss = {"propagation": {"function": "exponential", "alpha": 0.5}}
    bodies = [item | loss for item in floor_and_crate().document["objects"]]
    bodies = [
        item if item["name"] in shaped else {k: v for k, v in item.items() if k != "shape"}
        for item in bodies
    ]
    run = ht.open(
        ht.Scene(
            objects=[POST | loss, *bodies],
            sources=[{"name": "drill", "object": "post", "position": [5, 0, 2]}],
            listeners=[
                {"name": "foot", "object": "post", "position": [5, 0, 0], "radius": 0},
                {"name": "hand", "object": "crate", "position": [0, 0, 1]},
            ],
            contacts=[
                {
                    "objects": ["post", "crate"],
                    "positions": [[5, 0, 0], [0, 0, 0.5]],
                    "transmission": {"function": "identity"},
                }
            ],
        )
    )
    assert run.objects == ("post", "ground", "crate")
    run.step(0.0)
    hit = [{"objects": ["post", "crate"], "position": [5, 0, 3], "energy": 100.0}]
    step = run.step(0.02, impacts=hit)
    assert step.levels["foot"].gains["drill"] == pytest.approx(math.exp(-0.5 * 2))
    (blow,) = step.impacts
    assert set(blow.objects) == {"post", "crate"}
    assert blow.gains["foot"] == pytest.approx(math.exp(-0.5 * 3))
    run.replace(object=POST | loss)
    run.replace(object={k: v for k, v in bodies[1].items() if k != "shape"})
    run.add(object=POST | {"name": "crane", "shape": {"type": "sphere", "radius": 1}})
    assert run.objects == ("post", "ground", "crate", "crane")
    run.step(0.04, {"crate": (0, 0, 4, *STILL)})
    run.remove(object="ground")
    assert run.step(0.06).levels["foot"].gains["drill"] == pytest.approx(math.exp(-1))


def test_a_body_that_comes_back_without_its_shape_is_gone_from_the_search():
    """Meanwhile the engine has given contacts, so that nothing was searched for."""
    ball = {"name": "ball", "kappa": 0.1, "rho": 0.9, "shape": {"type": "sphere", "radius": 1}}
    run = ht.open(floor_and_crate())
    run.add(object=ball)
    run.step(0.0)
    run.remove(object="ball")
    run.step(0.02, contacts=[])
    run.add(object={"name": "ball", "kappa": 0.1, "rho": 0.9})
    assert run.step(0.04).levels["hand"].gains["drill"] > 0
