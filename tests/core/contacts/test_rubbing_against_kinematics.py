"""What slides and rolls: its frequency, level and silence against the laws that define them, and
the same bits from any frame on."""

import json

import numpy as np
import pytest
from haptic_tracing.core.contacts.settings import Body, ContactSettings
from haptic_tracing.core.contacts.shapes import Box, Cylinder, Sphere
from haptic_tracing.core.events.frame import EXACT_FRAMES
from haptic_tracing.core.formats.export import Export
from haptic_tracing.core.formats.haptic_scene import read_export, write_export
from haptic_tracing.core.formats.io.error import FormatError
from haptic_tracing.core.formats.scene.recording import SceneRecorder, traced
from haptic_tracing.core.formats.scene.scene_json import scene_from_dict, scene_to_dict
from haptic_tracing.core.scene.rule_table import Rule, RuleTable, Side
from haptic_tracing.core.scene.rules import Motion
from haptic_tracing.core.scene.texture import Texture
from haptic_tracing.core.scene.values import HapticObject, HapticScene, Listener
from haptic_tracing.core.tracer import Frame, Tracer
from scipy.spatial.transform import Rotation

RATE = 24.0
EDGE, RADIUS, WHEEL = 0.5, 0.2, 0.46
TONE = Texture(period=0.01, noise=0.0, full_force=1e6, full_speed=100.0)


def rules(*rows, **more):
    return ContactSettings(
        textures=RuleTable(tuple(Rule((Side(*a), Side(*b)), does) for a, b, does in rows)), **more
    )


def everywhere(texture):
    return rules(((), (), texture))


def placed(position, rotation=None):
    matrix = np.eye(4)
    matrix[:3, 3] = position
    if rotation is not None:
        matrix[:3, :3] = Rotation.from_rotvec(rotation).as_matrix()
    return matrix


def play(settings, shape, poses, mass=20.0, floor=None, first=0, lazy=False, layers=1):
    """Trace a body of this shape through ``poses`` on a floor whose upper side is at z = 0; a
    listener is on the body."""
    bodies = (
        Body("crate", shape, mass, material="Softwood", layers=layers),
        Body("floor", Box((60, 60, 1)), None, Motion.STATIC, material="Concrete", layers=5),
    )
    objects = tuple(HapticObject(body.name, 0.1, 0.9) for body in bodies)
    tracer = Tracer(settings, lazy=lazy)
    results = []
    for number in range(first, len(poses)):
        transforms = np.stack(
            [poses[number], placed((0, 0, -0.5)) if floor is None else floor[number]]
        )
        listeners = (Listener("hand", "crate", tuple(transforms[0, :3, 3]), radius=0.0),)
        exact = number % EXACT_FRAMES == 0
        frame = Frame(
            number,
            number / RATE,
            objects,
            (),
            listeners,
            bodies=bodies,
            transforms=transforms,
            exact=exact,
        )
        results.append(tracer.step(frame))
    return results


def slid(path):
    """Poses of a crate on the floor along a ``path`` of x and y, shape (n, 2)."""
    return [placed((x, y, EDGE / 2)) for x, y in path]


def straight(speed, frames):
    return np.stack([speed / RATE * np.arange(frames), np.zeros(frames)], axis=1)


def rolled(speed, frames, radius, slip=0.0):
    """Poses of a wheel or ball that rolls along x and slips by a part of its speed."""
    way = speed / RATE * np.arange(frames)
    return [placed((x, 0, radius), (0, (1 - slip) * x / radius, 0)) for x in way]


def samples(results):
    return np.concatenate([result.block[0] for result in results if result.block is not None])


def fundamental(wave, rate=8000):
    spectrum = np.abs(np.fft.rfft(wave * np.hanning(len(wave)), 1 << 18))
    return np.fft.rfftfreq(1 << 18, 1 / rate)[spectrum.argmax()]


def strongest(results, word):
    return max(
        (source.amplitude for source in results[-1].sources if word in source.name), default=0.0
    )


@pytest.mark.slow
@pytest.mark.parametrize("noise", [0.0, 0.7])
@pytest.mark.parametrize(
    ("speed", "period"), [(0.02, 0.0002), (0.5, 0.004), (1.3, 0.0071), (3.0, 0.08)]
)
def test_fundamental_of_what_slides_is_speed_over_period(speed, period, noise):
    texture = Texture(period, noise=noise, bandwidth=0.1, full_force=1.0, full_speed=1e-3)
    wave = samples(play(everywhere(texture), Box((EDGE,) * 3), slid(straight(speed, 60))))
    # A block of 32 frames may have half a cycle too much or too little; a band of noise has its
    # middle there.
    assert fundamental(wave[2000:]) == pytest.approx(
        speed / period, abs=0.5 * RATE / EXACT_FRAMES, rel=0.1 if noise else 0.0
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    ("shape", "radius", "upright"),
    [(Sphere(RADIUS), RADIUS, None), (Cylinder(WHEEL, 0.1), WHEEL, (np.pi / 2, 0, 0))],
)
def test_what_rolls_without_slipping_does_not_slide_and_has_its_speed_over_period(
    shape, radius, upright
):
    texture = Texture(0.01, rolling=1.0, noise=0.0, full_force=1.0, full_speed=1e-3)
    poses = rolled(1.5, 60, radius)
    if upright is not None:
        poses = [pose @ placed((0, 0, 0), upright) for pose in poses]
    results = play(everywhere(texture), shape, poses)
    assert {source.name.split()[1] for result in results for source in result.sources} == {
        "rolling"
    }
    assert fundamental(samples(results)[4000:]) == pytest.approx(150.0, abs=0.4)
    slipping = play(everywhere(texture), Sphere(RADIUS), rolled(1.5, 20, RADIUS, slip=0.5))
    assert strongest(slipping, "sliding") > 0 and strongest(slipping, "rolling") > 0


def test_what_shares_no_layer_of_collision_passes_without_sliding():
    path = slid(straight(1.0, 12))
    texture = everywhere(Texture(0.01, noise=0.0, full_force=1.0, full_speed=1e-3))
    for layers, slides in ((1, True), (2, False), (6, True)):
        results = play(texture, Box((EDGE,) * 3), path, layers=layers)
        assert len(results[-1].contacts.pairs) == 1
        assert (strongest(results, "sliding") > 0) == slides


def test_what_passes_through_each_other_does_so_without_sliding():
    for pair, slides in ((("floor", "crate"), False), (("crate", "wall"), True)):
        texture = Texture(0.01, noise=0.0, full_force=1.0, full_speed=1e-3)
        settings = rules(((), (), texture), passing=(pair,))
        results = play(settings, Box((EDGE,) * 3), slid(straight(1.0, 12)))
        assert len(results[-1].contacts.pairs) == 1
        assert (strongest(results, "sliding") > 0) == slides


def test_what_is_carried_along_neither_slides_nor_rolls():
    """Crate and floor together through the room, turning as on a ship."""
    turn = [placed((0.2 * k, 0.1 * k, 0.0), (0.02 * k, 0.01 * k, 0.03 * k)) for k in range(20)]
    results = play(
        everywhere(Texture(sliding=1.0, rolling=1.0)),
        Box((EDGE,) * 3),
        [pose @ placed((0, 0, EDGE / 2)) for pose in turn],
        floor=[pose @ placed((0, 0, -0.5)) for pose in turn],
    )
    assert not any(result.sources for result in results)


def test_what_pivots_on_the_spot_slides_as_fast_as_a_disc_of_its_patch_on_average():
    rate = 2.0
    poses = [placed((0, 0, EDGE / 2), (0, 0, rate / RATE * k)) for k in range(6)]
    texture = Texture(sliding=1.0, full_force=20 * 9.81, full_speed=10.0)
    expected = 2 / 3 * rate * EDGE / np.sqrt(np.pi)
    found = strongest(play(everywhere(texture), Box((EDGE,) * 3), poses), "sliding")
    assert found == pytest.approx((expected / 10.0) ** 0.75, rel=0.01)


@pytest.mark.parametrize("factor", [2.0, 5.0])
def test_level_goes_with_the_root_of_the_force_and_a_power_of_the_speed(factor):
    def level(speed=0.5, mass=10.0, shape=None, poses=None, word="sliding"):
        return strongest(
            play(
                everywhere(TONE), shape or Box((EDGE,) * 3), poses or slid(straight(speed, 8)), mass
            ),
            word,
        )

    reference = level()
    assert reference == pytest.approx(
        0.5 * (10 * 9.81 / 1e6) ** 0.5 * (0.5 / 100) ** 0.75, rel=1e-3
    )
    assert level(mass=10.0 * factor) == pytest.approx(reference * factor**0.5, rel=1e-3)
    assert level(speed=0.5 * factor) == pytest.approx(reference * factor**0.75, rel=1e-3)
    slow, fast = (
        level(shape=Sphere(RADIUS), poses=rolled(speed, 8, RADIUS), word="rolling")
        for speed in (0.5, 0.5 * factor)
    )
    assert fast == pytest.approx(slow * factor**1.5, rel=1e-3)


def test_level_ends_at_the_full_one_and_unknown_forces_count_as_full():
    texture = Texture(sliding=0.4, full_force=1.0, full_speed=0.1)
    assert (
        strongest(play(everywhere(texture), Box((EDGE,) * 3), slid(straight(2.0, 8))), "sliding")
        == 0.4
    )
    half = Texture(sliding=0.4, full_force=1e6, full_speed=2 ** (4 / 3))
    assert strongest(
        play(everywhere(half), Box((EDGE,) * 3), slid(straight(1.0, 8)), mass=None), "sliding"
    ) == pytest.approx(0.2)


@pytest.mark.parametrize("noise", [0.0, 0.3, 1.0])
def test_pieces_add_up_to_the_power_of_a_sine_whatever_part_of_it_is_noise(noise):
    texture, step, speed = Texture(0.004, noise=noise, bandwidth=1.0), 0.05, 1.0
    wave = np.zeros(8000 * 60)
    for number in range(1198):
        piece = texture.piece(speed, speed / 0.004 * step * (number + 0.5), step, number)
        wave[400 * number : 400 * (number + 2)] += piece.sample(0, 800, 8000.0)
    assert np.mean(wave[400:-800] ** 2) == pytest.approx(0.5, rel=0.05 if noise else 1e-6)


def test_slow_surfaces_stick_and_slip():
    """Half of the wave is a saw at half the speed, and all of it near standstill: its second
    harmonic is half as strong as its first."""
    texture = Texture(0.004, noise=0.0, stick_speed=0.4)
    for speed, share in ((0.2, 0.5), (0.0004, 0.999), (0.8, 0.0)):
        frequency = speed / 0.004
        wave = texture.piece(speed, 0.0, 100 / frequency, 0).sample(40_000, 40_000, 400 * frequency)
        spectrum = np.abs(np.fft.rfft(wave))
        expected = (share / np.pi) / (share * 2 / np.pi + 1 - share)
        assert spectrum[200] / spectrum[100] == pytest.approx(expected, abs=0.01)


@pytest.mark.parametrize("lazy", [False, True])
def test_at_rest_all_is_silent_to_the_last_bit(lazy):
    still = [(0.0, 0.0)] * 8
    path = np.array([*still, *straight(0.7, 20), *([tuple(straight(0.7, 20)[-1])] * 8)])
    results = play(everywhere(Texture()), Box((EDGE,) * 3), slid(path), lazy=lazy)
    assert all(not result.sources and not result.block.any() for result in results[1:9])
    assert all(result.block.any() for result in results[10:27])
    assert all(not result.sources and not result.block.any() for result in results[29:])
    trembling = np.array(still) + 2e-6 * np.random.default_rng(1).normal(size=(8, 2))
    assert not any(
        result.sources for result in play(everywhere(Texture()), Box((EDGE,) * 3), slid(trembling))
    )


def test_no_clicks_where_speed_and_direction_change():
    """The second difference of a sine of f hertz is at most (2 pi f / rate)^2 of it."""
    frames = np.arange(50)
    way = np.cumsum(0.8 / RATE * (1 + np.sin(frames / 4.0)) / 2)
    path = np.stack([2 * np.cos(way / 2), 2 * np.sin(way / 2)], axis=1)
    results = play(
        everywhere(Texture(0.01, sliding=1.0, noise=0.0, full_force=1.0, full_speed=1e-3)),
        Box((EDGE,) * 3),
        slid(path),
    )
    wave = samples(results)
    assert np.abs(np.diff(wave, 2)).max() < 1.1 * (2 * np.pi * 80 / 8000) ** 2 * np.abs(wave).max()


@pytest.mark.slow
def test_a_frame_depends_on_two_blocks_of_frames_alone():
    """Along a curve, faster and slower: traced from the block before on, the same to the bit; and
    so is what later frames depend on."""
    frames = np.arange(72)
    way = np.cumsum(0.05 * (1.2 + np.sin(frames / 5.0)))
    poses = slid(np.stack([3 * np.cos(way / 3), 3 * np.sin(way / 3)], axis=1))
    whole = play(everywhere(Texture()), Box((EDGE,) * 3), poses)
    for ours in play(everywhere(Texture()), Box((EDGE,) * 3), poses, first=EXACT_FRAMES)[
        EXACT_FRAMES + 1 :
    ]:
        assert np.array_equal(ours.block, whole[ours.number].block) and ours.block.any()


def test_most_specific_row_counts_and_without_one_nothing_plays():
    poses = slid(straight(1.0, 6))
    named = rules(
        ((), (), Texture(sliding=0.1)),
        (("crate",), ("", "Conc*"), Texture(sliding=0.9, full_force=1.0, full_speed=0.01)),
    )
    assert strongest(play(named, Box((EDGE,) * 3), poses), "sliding") == 0.9
    assert not any(
        result.sources
        for result in play(rules((("", "Ice"), (), Texture())), Box((EDGE,) * 3), poses)
    )
    silent = rules(((), (), Texture(period=1e-5)))  # 100 kHz
    assert not any(result.sources for result in play(silent, Box((EDGE,) * 3), poses))


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"period": 0.0}, "period"),
        ({"noise": 1.5}, "noise"),
        ({"sliding": np.nan}, "sliding"),
        ({"full_speed": np.inf}, "full_speed"),
    ],
)
def test_faults_are_named(values, words):
    with pytest.raises(ValueError, match=words):
        Texture(**values)


ROW = {
    "between": [{"object": "crate"}, {"material": "Conc*"}],
    "period": 0.002,
    "noise": 0.25,
    "stick_speed": 0.1,
}


def document(poses, **more):
    crate = {
        "name": "crate",
        "kappa": 0.1,
        "rho": 0.9,
        "mass": 20.0,
        "shape": {"type": "box", "size": [EDGE] * 3},
        "pose": poses[0],
    }
    floor = {
        "name": "floor",
        "kappa": 0.1,
        "rho": 0.9,
        "motion": "static",
        "material": "Concrete",
        "pose": {"position": [0, 0, -0.5]},
    }
    floor["shape"] = {"type": "box", "size": [60, 60, 1]}
    frames = [
        {"frame": k, "poses": {"crate": [*pose["position"], 1, 0, 0, 0]}}
        for k, pose in enumerate(poses)
    ]
    return {
        "format": "haptic-scene", "version": "1.1", "objects": [crate, floor], "frame_rate": RATE, "frames": frames,
        "listeners": [{"name": "hand", "object": "crate", "position": [0, 0, EDGE / 2]}], "rules": {"textures": [ROW]}, **more,
    }  # fmt: skip


def test_a_file_of_shapes_and_poses_plays_its_textures(tmp_path):
    path = straight(0.5, 40).round(6)
    (tmp_path / "a.json").write_text(
        json.dumps(document([{"position": [x, y, EDGE / 2]} for x, y in path.tolist()]))
    )
    export = read_export(tmp_path / "a.json")
    assert scene_to_dict(export.scene)["rules"]["textures"] == [ROW]
    assert scene_from_dict(scene_to_dict(export.scene), "b.json").rules == export.scene.rules
    found = list(traced(export.scene, export.recording))
    ours = play(
        rules((("crate",), ("", "Conc*"), Texture(0.002, noise=0.25, stick_speed=0.1))),
        Box((EDGE,) * 3),
        slid(path),
    )
    for theirs, mine in zip(found, ours, strict=True):
        assert [source.name for source in theirs.sources] == [
            source.name for source in mine.sources
        ]
    assert fundamental(samples(found)[4000:]) == pytest.approx(250, abs=1)


def test_a_recording_with_contacts_plays_as_it_was_traced(tmp_path):
    path = np.concatenate([straight(0.5, 40), np.repeat(straight(0.5, 40)[-1:], 8, axis=0)]).round(
        6
    )
    results = play(
        everywhere(Texture()), Box((EDGE,) * 3), slid([*path, *(path[-1] + straight(0.3, 8))])
    )
    recorder = SceneRecorder(RATE, 0)
    objects = (HapticObject("crate", 0.1, 0.9), HapticObject("floor", 0.1, 0.9))
    for result in results:
        recorder.add(
            result.number,
            objects,
            result.sources,
            result.listeners,
            result.contacts,
            result.objects,
        )
    write_export(Export("a", recorder.scene(), recording=recorder.recording()), tmp_path / "a.json")
    export = read_export(tmp_path / "a.json")
    for ours, theirs in zip(results, traced(export.scene, export.recording), strict=True):
        if ours.block is not None:
            assert theirs.block == pytest.approx(ours.block, rel=1e-12, abs=1e-12)
    assert isinstance(export.scene, HapticScene)


@pytest.mark.parametrize(
    ("row", "pointer"),
    [({"period": -1}, "/period"), ({"noise": "much"}, "/noise"), ({"colour": 1}, "/colour")],
)
def test_faults_of_rows_name_their_place(tmp_path, row, pointer):
    (tmp_path / "a.json").write_text(
        json.dumps(document([{"position": [0, 0, 1]}], rules={"textures": [{}, row]}))
    )
    with pytest.raises(FormatError) as caught:
        read_export(tmp_path / "a.json")
    assert caught.value.pointer == f"/rules/textures/1{pointer}"
