"""The plan of a study with people: its form, its orders, and what a participant may answer."""

import sys
from collections import Counter
from itertools import islice, pairwise, product

import bounded_program
import pytest
from haptic_tracing.command_line import build_parser, main
from haptic_tracing.study.people.plan import balanced_rows, begin, orders, read_form, stimuli
from haptic_tracing.study.people.record import Sitting, add_step, alone, read_steps

FORM = """
title = "T"
smallest_effect = 0.5
consent = "C"
instructions = "I"
about = {age = []}
words = []
scale = {low = 1, high = 5}
items = [{factor = "Realism", text = "R"}]
exclusion = {incomplete = true, same_answers = true, seconds_per_item = 0, missed_ms = 500}
conditions = {a = {}, b = {}, c = {}, d = {}}
scenes = {x = {tracks = {}}, y = {tracks = {}}, z = {tracks = {}}}
"""


@pytest.fixture
def sitting(tmp_path):
    (tmp_path / "study.toml").write_text(FORM)
    return seated(tmp_path)


def seated(folder):
    form = read_form(folder)
    return Sitting(folder, "P01", begin(folder, form, 4, ["hand.L"], {}))


@pytest.mark.parametrize("count", [1, 2, 3, 4, 5, 6, 7])
def test_squares_are_balanced(count):
    """By definition: each name at each place, and after each other one, equally often."""
    times = 2 if count % 2 else 1
    rows = list(islice(balanced_rows("abcdefg"[:count], "3"), times * count))
    places = Counter((place, name) for row in rows for place, name in enumerate(row))
    assert set(places.values()) == {times} and len(places) == count**2
    followed = Counter(pair for row in rows for pair in pairwise(row))
    assert set(followed.values()) <= {times} and len(followed) == count * (count - 1)


def ordered(conditions, scenes, participants, seed):
    form = {"conditions": dict.fromkeys(conditions), "scenes": dict.fromkeys(scenes), "seed": seed}
    return orders(form, participants)


def test_orders_are_balanced_over_participants_and_sections():
    found = ordered("abcd", "xyz", 24, 5)
    first = Counter(
        (step["position"], step["condition"])
        for steps in found.values()
        for step in steps
        if step["step"] == "rate"
    )
    assert set(first.values()) == {6} and len(first) == 16
    played = [[step for step in steps if step["step"] == "play"] for steps in found.values()]
    assert all(len(steps) == 4 * 3 for steps in played)
    within = Counter((k % 3, step["scene"]) for steps in played for k, step in enumerate(steps))
    assert set(within.values()) == {32} and len(within) == 9
    assert ordered("abcd", "xyz", 24, 6) != found
    assert dict(list(found.items())[:10]) == ordered("abcd", "xyz", 10, 5)


def test_the_first_call_leaves_a_form_that_says_what_is_missing(tmp_path, capsys):
    command = ["study", "run", "--participants", "2", "--out", str(tmp_path / "new")]
    for missing in ("fill in the consent", "/consent"):
        assert main(command) == 2
        assert missing in capsys.readouterr().err
    form = tmp_path / "new" / "study.toml"
    form.write_text(form.read_text().replace('consent = ""', 'consent = "Yes."'))
    assert main(command) == 2
    assert "/items/0/text" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("old", "new", "where"),
    [
        ('text = "R"', 'text = ""', "/items/0/text"),
        ("b = {}", "a = {}", "not TOML"),
        ("x = {tracks = {}}", "x = {}", "/scenes/x"),
        (", b = {}, c = {}, d = {}", "", "/conditions"),
        ("smallest_effect = 0.5", "smallest_effect = -1", "/smallest_effect"),
        ('title = "T"', "title = ", "not TOML"),
        ("low = 1", "low = 5", "/scale/high"),
        ('"R"}]', '"R"}, {factor = "Harmony", text = "R"}]', "/items/1/text"),
    ],
)
def test_a_form_with_a_fault_is_named(tmp_path, old, new, where):
    (tmp_path / "study.toml").write_text(FORM.replace(old, new))
    with pytest.raises(ValueError, match=where):
        read_form(tmp_path)


def test_a_form_may_not_change_once_the_study_has_begun(sitting, tmp_path):
    (tmp_path / "study.toml").write_text(FORM.replace('"R"', '"Other"'))
    with pytest.raises(ValueError, match="or the tracks have changed"):
        seated(tmp_path)


def test_tracks_may_not_change_once_the_study_has_begun(sitting, tmp_path):
    form, other = read_form(tmp_path), {"a": {"x": [0.5]}}
    with pytest.raises(ValueError, match="tracks have changed since the study began"):
        begin(tmp_path, form, 4, ["hand.L"], other)


def test_other_settings_are_rendered_into_other_files(tmp_path):
    scenes = {"x": {"sample": "pile", "frames": [1, 9]}, "y": {"tracks": {"a": "mine.wav"}}}
    form = {"conditions": {"a": {"settings": ["scene.haptics.mode=HT"]}, "b": {}}, "scenes": scenes}
    before = stimuli(tmp_path, form)
    form["conditions"]["a"] = {"settings": ["scene.haptics.mode=SD"]}
    now = stimuli(tmp_path, form)
    assert {key for key in now if now[key] != before[key]} == {("x", "a")}
    scenes["x"]["frames"] = [1, 8]
    later = stimuli(tmp_path, form)
    assert {key for key in now if later[key] != now[key]} == {("x", ""), ("x", "a"), ("x", "b")}


def test_a_sitting_resumes_where_its_file_ends(sitting, tmp_path):
    sitting.take(0, [], 1.0)
    sitting.take(1, [{"item": "age", "value": "30"}], 1.0)
    add_step(sitting.path, {"note": "a remark"})
    again = seated(tmp_path)
    assert again.done == 2 and again.step == {"step": "start"}
    sitting.take(0, [], 1.0)  # a page that is late
    assert again.steps == sitting.steps and len(again.steps) == 3 + 4 * (3 * 2 + 1) + 3


def test_a_full_disk_loses_no_answer(sitting, tmp_path):
    """The system writes the part that there is room for, and says so only by its length."""
    resource = pytest.importorskip("resource")
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)

    def answered(number):
        return [{"item": "q", "value": f"{number} " + "x" * 3000}]

    sitting.take(0, answered(0), 1.0)
    sitting.take(1, answered(1), 1.0)
    before = sitting.path.read_bytes()
    resource.setrlimit(resource.RLIMIT_FSIZE, (len(before) + 1000, limits[1]))
    try:
        with pytest.raises(OSError):
            sitting.take(2, answered(2), 1.0)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    assert sitting.path.read_bytes() == before
    assert sitting.done == seated(tmp_path).done == 2
    sitting.take(2, answered(2), 1.0)
    steps = read_steps(sitting.path)
    assert [step["answer"] for step in steps] == [answered(k) for k in range(3)]
    assert [step["step"] for step in steps] == [step["step"] for step in sitting.steps[:3]]


def test_two_programs_can_not_seat_people_in_one_folder(sitting, tmp_path):
    program = [
        "from pathlib import Path",
        "from haptic_tracing.study.people.record import alone",
        f"with alone(Path({str(tmp_path)!r})): pass",
    ]
    command = [sys.executable, "-c", "\n".join(program)]
    with alone(tmp_path):
        done = bounded_program.run(command)
        assert done.returncode and "another `haptic-tracing study run`" in done.stderr
    assert bounded_program.run(command).returncode == 0


SPOT = {"item": "back", "value": "hand.L", "x": 0, "y": 1}
BAD = [
    [True], "yes", None, [None], [{"item": "age"}], [{"item": "age", "value": "x" * 20_000}],
    [{**SPOT, "part": "more"}], [{**SPOT, "x": 1e9}], [SPOT] * 201, [{**SPOT, "value": [1]}],
]  # fmt: skip


def test_only_answers_of_items_and_values_are_written(sitting, tmp_path):
    answer = [{"item": "noticed", "value": 1}, SPOT]
    while sitting.step:
        for bad in BAD:
            with pytest.raises((ValueError, TypeError)):
                sitting.take(sitting.done, bad, 1.0)
        sitting.take(sitting.done, answer, 1.234)
    steps = read_steps(tmp_path / "P01.jsonl")
    assert [step.pop("at") for step in steps] and steps == [
        {**step, "answer": answer, "seconds": 1.23} for step in sitting.steps
    ]
    sitting.take(len(steps), answer, 1.0)
    assert len(read_steps(tmp_path / "P01.jsonl")) == len(steps)
    (rank,) = (step for step in sitting.steps if step["step"] == "rank")
    rated = [step["condition"] for step in sitting.steps if step["step"] == "rate"]
    assert rank["conditions"] == rated


def test_each_order_of_a_pair_is_possible():
    found = {tuple(ordered("ab", "x", 2, seed)["P01"][-3]["conditions"]) for seed in range(20)}
    assert found == {pair for pair in product("ab", repeat=2) if pair[0] != pair[1]}


def test_commands_of_earlier_versions_are_still_understood():
    parsed = build_parser().parse_args(
        ["study", "--out", "x", "--frames", "1:9", "--pictures", "0"]
    )
    assert parsed.command == "study" and parsed.frames == (1, 9) and str(parsed.out) == "x"
    assert build_parser().parse_args(["study"]).out.as_posix() == "out/study"
    assert build_parser().parse_args(["study", "analyse", "x"]).command == "study_analyse"
