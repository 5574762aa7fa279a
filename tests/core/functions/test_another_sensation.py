"""The example of another sensation in the documentation, against the fin equation."""

import math
from pathlib import Path

import haptic_tracing
import pytest

PAGE = Path(haptic_tracing.__file__).parent / "docs" / "functions.md"


def test_the_example_of_heat_is_the_solution_of_the_fin_equation():
    """k t T'' = 2 h T over 0.6 m of steel, then over 0.02 m of wood (Incropera and others,
    "Fundamentals of Heat and Mass Transfer", section 3.6)."""
    text = PAGE.read_text(encoding="utf-8").partition("## Another sensation")[2]
    names = {}
    exec(text.partition("```python\n")[2].partition("```")[0], names)
    steel, wood = (math.sqrt(2 * 10 / (k * t)) for k, t in ((50.0, 0.01), (0.15, 0.03)))
    assert names["warmer"] == pytest.approx(600 * math.exp(-steel * 0.6 - wood * 0.02), rel=1e-9)
