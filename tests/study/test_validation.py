"""The validation page: its asked limits, and that the page in the
documentation is this one."""

import importlib.util
import math
from functools import partial
from pathlib import Path

import pytest
from haptic_tracing.core.scene.functions import Physical
from haptic_tracing.core.scene.materials import MATERIALS
from haptic_tracing.study.validation import (
    Point,
    Series,
    all_series,
    fitted,
    levels,
    unfitted,
)

DOCS = Path(__file__).resolve().parents[2] / "docs"


def test_what_is_asked_holds_and_misses_are_explained():
    verdicts = {series.name: series for series in all_series()}
    for name in (
        "Construction machines",
        "Outside a machine hall",
        "Concrete in a building, 200 mm",
    ):
        assert verdicts[name].verdict == "agrees", name
    for frequency in (28, 113, 226):
        (order,) = verdicts[f"Order of materials at {frequency} Hz"].points
        assert order.measured == 353 and order.modelled >= 0.98 * order.measured
    assert all(series.remark for series in verdicts.values() if series.verdict != "agrees")


def test_held_out_rows_name_the_line_that_a_fit_would_change():
    held = [series for series in all_series() if series.kind == "held out"]
    assert len({series.source for series in held} - {"as above"}) >= 5
    for series in all_series():
        assert (series.uses is not None) == (series.kind == "held out"), series.name
        assert series.chosen.startswith("nothing") or series.kind in ("fit", "chosen"), series.name
    for path, line in {series.uses for series in held}:
        assert line in (DOCS.parent / path).read_text(encoding="utf-8"), line


def test_soil_unfitted_is_the_closed_form_of_a_damped_surface_wave():
    places = [13.0, 23.0, 43.0, 73.0]
    soil = MATERIALS["soil"]
    expected = [
        -10 * math.log10(r / 13) - 20 * math.log10(math.e) * math.pi * 50 * 0.06 / 200 * (r - 13)
        for r in places
    ]
    assert soil.title == "Soil" and unfitted("soil", 50.0, places) == pytest.approx(
        expected, abs=0.2
    )


def test_scatter_decides_where_it_is_published():
    inside, outside = Point("a", -4.0, -8.5, spread=5.0), Point("b", -4.0, -9.5, spread=5.0)
    made = partial(Series, "", "", "", "held out", "dB", limit=3.0, remark="", chosen="nothing")
    assert made((inside,)).verdict == "agrees"
    assert made((inside, outside)).verdict == "missed"
    assert made((Point("c", 0.0, 3.5),)).verdict == "missed"


def test_a_fit_finds_the_absorption_that_made_the_levels():
    made = Physical(loss_factor=0.0, absorption=0.03, thickness=1e6, extent=1e6)
    places = [5.0, 10.0, 20.0, 40.0]
    assert fitted(
        made, places, list(levels(made, places)), [False, True, False, True]
    ).absorption == pytest.approx(0.03, rel=1e-12)


def test_the_documentation_has_this_page(tmp_path, capsys):
    specification = importlib.util.spec_from_file_location(
        "write_validation_page", DOCS / "write_validation_page.py"
    )
    writer = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(writer)
    writer.main(tmp_path)
    assert "agrees   fit         Construction machines" in capsys.readouterr().out
    for name in ("validation.md", "pictures/validation.svg", "pictures/body.svg"):
        written = (tmp_path / name).read_text(encoding="utf-8")
        assert written == (DOCS / name).read_text(encoding="utf-8"), name
