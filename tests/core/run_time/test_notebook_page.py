"""Every snippet of `docs/notebook.md`, run in one go as a reader would."""

import re
from pathlib import Path

import pytest

PAGE = Path(__file__).parents[3] / "docs" / "notebook.md"


def test_the_snippets_compute_gains_and_a_drop(capsys):
    snippets = re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    names = {}
    for snippet in snippets:
        exec(compile(snippet, PAGE.name, "exec"), names)
    assert len(snippets) == 4
    assert names["result"]["drill", "seat"].path == ("ground", "bench")
    said = re.search(r"# (\{.*?)\.\.\.\}", snippets[0])[1]
    assert capsys.readouterr().out.startswith(said)
    assert names["scene"].contacts()[0].objects == ("ground", "bench")
    assert names["blow"].energy == pytest.approx(20 * 9.81 * 0.5, rel=0.03)
    assert names["blow"].time == pytest.approx((2 * 0.5 / 9.81) ** 0.5, abs=2e-3)
    assert names["loudness"].max() > -40
