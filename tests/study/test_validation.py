"""The validation page: its solver against closed forms, its asked limits, and that the page in the
documentation is this one."""

import math
from pathlib import Path

import numpy as np
import pytest
from haptic_tracing.command_line import main
from haptic_tracing.core.scene.functions import Physical, Wave
from haptic_tracing.study.validation import PLATES, all_series, fitted, levels
from haptic_tracing.study.validation import plate_energies as solved
from haptic_tracing.study.validation_page import body_picture, page, picture

DOCS = Path(__file__).resolve().parents[2] / "docs"


def by_hand(plates, frequency):
    """The equations of statistical energy analysis as they stand in books, solved by NumPy; plate
    speeds from bending stiffness."""
    stiffness, mass = 210e9 * 3e-3**3 / (12 * (1 - 0.3**2)), 7800 * 3e-3
    group_speed = 2 * (stiffness / mass) ** 0.25 * math.sqrt(2 * math.pi * frequency)
    coupling = group_speed * plates.transmission / (2 * math.pi**2 * frequency)
    n = plates.count
    matrix = np.full((n, n), -coupling) + np.eye(n) * (0.01 + n * coupling)
    return np.linalg.solve(2 * math.pi * frequency * matrix, np.eye(n)[0])


@pytest.mark.parametrize("plates", PLATES, ids=lambda one: one.name)
def test_the_solver_agrees_with_the_books_equations_to_a_millionth(plates):
    for frequency in plates.printed:
        assert solved(plates, frequency) == pytest.approx(by_hand(plates, frequency), rel=1e-6)


def test_what_is_asked_holds_and_misses_are_explained():
    verdicts = {series.name: series for series in all_series()}
    for name in (
        "Construction machines",
        "Outside a machine hall",
        "Two plates, L joint",
        "Plate and cylinder",
        "Concrete in a building, 200 mm",
    ):
        assert verdicts[name].verdict == "agrees", name
    for frequency in (30, 100, 300):
        order = verdicts[f"Order of materials at {frequency} Hz"]
        assert order.verdict == "agrees" and order.points[0].measured > 100
    assert all(series.remark for series in verdicts.values() if series.verdict != "agrees")


def test_a_fit_finds_the_absorption_that_made_the_levels():
    made = Physical(wave=Wave.SOLID, loss_factor=0.0, absorption=0.03, material_k=0.5)
    places = [5.0, 10.0, 20.0, 40.0]
    assert fitted(
        made, places, list(levels(made, places)), [False, True, False, True]
    ).absorption == pytest.approx(0.03, rel=1e-12)


def test_the_documentation_has_this_page(tmp_path, capsys):
    assert main(["validate", "--out", str(tmp_path)]) == 0
    assert "agrees   printed     Two plates, L joint" in capsys.readouterr().out
    assert (
        (tmp_path / "validation.md").read_text(encoding="utf-8")
        == page()
        == (DOCS / "validation.md").read_text(encoding="utf-8")
    )
    assert picture() == (DOCS / "pictures" / "validation.svg").read_text(encoding="utf-8")
    assert body_picture() == (DOCS / "pictures" / "body.svg").read_text(encoding="utf-8")
