"""The folder of a study with people: what is read from it and written into it."""

import json

import numpy as np
import pandas
import pytest
from haptic_tracing.command_line import main
from haptic_tracing.study.people.record import add_step, read_plan, read_steps, scores, tidy

CONDITIONS = ("HT", "SD", "MD", "MN")
PARTS = ("upper_leg.L", "upper_leg.R", "hand.L")
ITEMS = [
    {"factor": factor, "text": f"{factor} {turned}", "reversed": turned}
    for factor in ("Realism", "Expressivity")
    for turned in (False, True)
]
PEOPLE = 12


pytestmark = pytest.mark.slow


def rows(**values):
    """An answer as it is stored."""
    return [{"item": item, "value": value} for item, value in values.items()]


@pytest.fixture
def folder(tmp_path):
    """A study of 12, of whom P03 gives one answer to everything, P04 has not finished, and P05 is
    hasty."""
    generator = np.random.default_rng(1)
    names = [f"P{k + 1:02}" for k in range(PEOPLE)]
    form = {
        "title": "Legs & <hands>",
        "scale": {"low": 1, "high": 7},
        "items": ITEMS,
        "exclusion": {
            "incomplete": True,
            "same_answers": True,
            "seconds_per_item": 1.0,
            "missed_ms": 500,
        },
        "smallest_effect": 0.5,
        "conditions": {key: {} for key in CONDITIONS},
    }
    plan = {
        "form": form,
        "listeners": PARTS,
        "levels": {name: {"Stalactites": [0.5, 0.1, 0.0]} for name in CONDITIONS},
        "orders": {name: [] for name in names},
    }
    (tmp_path / "study.json").write_text(json.dumps(plan))
    for name in names:
        path = tmp_path / f"{name}.jsonl"
        add_step(path, {"step": "about", "answer": rows(age="31")})
        for k, condition in enumerate(CONDITIONS):
            about = {"condition": condition, "scene": "Stalactites"}
            felt = {"item": "front", "value": "upper_leg.L", "x": 0.1, "y": 1.5}
            add_step(path, {"step": "place", **about, "answer": [*rows(noticed=1), felt]})
            low = int(generator.integers(1, 3))
            rated = [7] * 4 if name == "P03" else [7 - k - low, k + low] * 2
            seconds = 2.0 if name == "P05" else 20.0
            answer = rows(**{item["text"]: one for item, one in zip(ITEMS, rated, strict=True)})
            step = {"step": "rate", "condition": condition, "answer": answer, "seconds": seconds}
            add_step(path, step)
        add_step(path, {"step": "rank", "answer": rows(HT=1, SD=2, MD=3, MN=4)})
        if name != "P04":
            add_step(path, {"step": "end", "answer": []})
    return tmp_path


def test_the_rules_of_the_plan_exclude(folder):
    reasons = tidy(folder, read_plan(folder)).groupby("participant")["excluded"].first()
    assert reasons[reasons != ""].to_dict() == {
        "P03": "the same answer to every question",
        "P04": "not finished",
        "P05": "less than 1 s per question",
    }
    for name, missed in {"P06": 501.0, "P07": 499.0}.items():
        played = {"step": "play", "answer": rows(late_ms=1.0, missed_ms=missed)}
        add_step(folder / f"{name}.jsonl", played)
    reasons = tidy(folder, read_plan(folder)).groupby("participant")["excluded"].first()
    assert (reasons["P06"], reasons["P07"]) == ("501 ms of a section were not played", "")


def test_reversed_items_are_turned_before_the_mean(folder):
    plan = read_plan(folder)
    answers = tidy(folder, plan)
    table = scores(answers[answers["excluded"] == ""], plan["form"])["Realism"]
    steps = read_steps(folder / "P01.jsonl")
    for step in steps:
        if step["step"] == "rate":
            a, b, *_ = (row["value"] for row in step["answer"])
            assert table.loc["P01", step["condition"]] == (a + 8 - b) / 2
    assert list(table.index) == [f"P{k:02}" for k in (1, 2, 6, 7, 8, 9, 10, 11, 12)]


def test_analyse_writes_tables_and_a_page_beside_the_papers_numbers(folder, capsys):
    assert main(["study", "analyse", str(folder)]) == 0
    assert str(folder / "analysis.html") in capsys.readouterr().out
    pairs = pandas.read_csv(folder / "pairs.csv")
    realism = pairs[(pairs["factor"] == "Realism") & (pairs["pair"] == "HT - SD")].iloc[0]
    assert realism["paper"] == "HT > SD" and realism["rank-biserial"] > 0
    places = pandas.read_csv(folder / "places.csv")
    assert places["at the strongest"].tolist() == [1.0] * 4
    assert pandas.read_csv(folder / "preferred.csv")["paper"].tolist() == [19, 4, 10, 8]
    answers = pandas.read_csv(folder / "answers.csv")
    assert (answers["step"] == "rate").sum() == PEOPLE * 4 * len(ITEMS)
    page = (folder / "analysis.html").read_text("utf-8")
    assert "15.5" in page and "Legs &amp; &lt;hands&gt;" in page and "$" not in page
    assert "<script" not in page
    # All nine who are kept gave HT the first rank.
    assert (
        page.count('9 <meter max="9" value="9">') == page.count('0 <meter max="9" value="0">') / 3
    )


def test_sections_that_were_not_felt_as_a_whole_are_listed(folder):
    for name, missed in (("P01", 40.0), ("P02", 900.0)):
        about = {
            "condition": "SD",
            "scene": "Stalactites",
            "answer": rows(late_ms=1, missed_ms=missed),
        }
        add_step(folder / f"{name}.jsonl", {"step": "play", **about})
        add_step(folder / f"{name}.jsonl", {"step": "end", "answer": []})
    assert main(["study", "analyse", str(folder)]) == 0
    assert pandas.read_csv(folder / "missed.csv").to_numpy().tolist() == [
        ["P02", "SD", "Stalactites", 900.0]
    ]


def test_two_conditions_are_analysed(folder):
    """A study of HT and SD alone."""
    plan = json.loads((folder / "study.json").read_text())
    plan["form"]["conditions"] = {"HT": {}, "SD": {}}
    (folder / "study.json").write_text(json.dumps(plan))
    for path in folder.glob("P*.jsonl"):
        steps = read_steps(path)
        path.unlink()
        for step in steps:
            if step["step"] == "rank":
                step["answer"] = rows(HT=1, SD=2)
            if step.get("condition") in (None, "HT", "SD"):
                add_step(path, step)
    assert main(["study", "analyse", str(folder)]) == 0
    (ranking, *_) = pandas.read_csv(folder / "factors.csv").to_dict("records")
    assert ranking["people"] == 9 and ranking["chi-square"] == pytest.approx(9.0)
    assert len(pandas.read_csv(folder / "pairs.csv")) == 3


def test_a_study_that_nobody_has_finished_is_named(folder, capsys):
    for path in folder.glob("P*.jsonl"):
        path.unlink()
    assert main(["study", "analyse", str(folder)]) == 2
    assert "nobody has ranked" in capsys.readouterr().err


def test_a_folder_without_a_study_is_named(tmp_path, capsys):
    assert main(["study", "analyse", str(tmp_path)]) == 2
    assert "no study" in capsys.readouterr().err


def test_a_line_that_was_cut_off_is_left_out_and_replaced(tmp_path):
    path = tmp_path / "P01.jsonl"
    add_step(path, {"step": "consent"})
    whole = path.read_bytes()
    path.write_bytes(whole + whole[: len(whole) // 2])
    assert [step["step"] for step in read_steps(path)] == ["consent"]
    add_step(path, {"step": "about"})
    assert [step["step"] for step in read_steps(path)] == ["consent", "about"]
    assert path.read_bytes().startswith(whole)


def test_a_study_whose_participants_are_all_excluded_has_empty_tables(folder):
    for path in folder.glob("P*.jsonl"):
        if path.stem != "P03":
            path.unlink()
    assert main(["study", "analyse", str(folder)]) == 0
    assert pandas.read_csv(folder / "excluded.csv")["participant"].tolist() == ["P03"]


def test_answers_are_no_formulas_in_a_spreadsheet(folder):
    hostile = ["=HYPERLINK(A1)", " +1", "-2+3", "@SUM(A1)", "plain - text"]
    add_step(folder / "P01.jsonl", {"step": "words", "answer": rows(**{w: w for w in hostile})})
    assert main(["study", "analyse", str(folder)]) == 0
    table = pandas.read_csv(folder / "answers.csv")
    said = table[table["step"] == "words"]["value"].tolist()
    assert said == [*(f"'{one}" for one in hostile[:4]), hostile[4]]
