"""Every snippet of `docs/scripting.md`, run in one go as a reader would."""

import json
import re
from pathlib import Path

import pytest
from explicit_graph import explicit_graph

PAGE = Path(__file__).parents[2] / "docs" / "scripting.md"


@pytest.mark.plugins
def test_the_snippets_tag_trace_bake_export_and_compute_again(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    snippets = re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    names = {}
    for snippet in snippets:
        # Here the extension is installed as a package.
        exec(
            compile(
                snippet.replace("bl_ext.user_default.haptic_tracing", "haptic_tracing"),
                PAGE.name,
                "exec",
            ),
            names,
        )
    assert len(snippets) == 7
    result = names["result"]
    assert result.path_objects(0, 0) == ("Ground", "Table")
    assert 0 < result.amplitudes[0, 0] < 0.8
    assert names["gain"] == pytest.approx(result.gains[0, 0], rel=1e-6)
    assert 0.8 * result.gains[0, 0] == pytest.approx(result.amplitudes[0, 0], rel=1e-6)
    expected = explicit_graph(result.graph)
    assert set(expected.edges) == set(names["edges"].edges)
    for one, other, edge in names["edges"].edges(data=True):
        assert edge == pytest.approx(expected.edges[one, other])
    assert names["table"].haptics.material.name == "Hardwood"
    assert json.loads((tmp_path / "table.hjif").read_text(encoding="utf-8"))["perceptions"]
    assert (
        len(json.loads((tmp_path / "table.json").read_text(encoding="utf-8"))["frames"]) == 25
    )  # with that at which the last one ends
