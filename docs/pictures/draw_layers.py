"""Draws docs/pictures/layers.svg from the imports: the layers of the package, and what each imports
directly.

python docs/pictures/draw_layers.py      (part of `make docs`)

An arrow leads from a layer to one that it imports; those that follow from other arrows are left
out.
"""

from __future__ import annotations

import sys
from pathlib import Path

import networkx

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
sys.path.insert(0, str(ROOT / "tests" / "references"))

from import_graph import LAYERS, imports, layer  # noqa: E402

WIDTH, ROW, BOX, GAP = 760, 46, (128, 26), 22
COLOURS = {"core": "#3f6f9f", "addon": "#8a5a2b"}
STYLE = (
    "text{font:13px "
    "sans-serif;fill:#fff;text-anchor:middle}line{stroke:#888;stroke-width:1.2;marker-end:url(#tip)}"
)


def places() -> dict[str, tuple[float, float]]:
    """Middle of each layer's box; the lowest layer at the bottom."""
    found = {}
    for row, parts in enumerate(reversed(LAYERS)):
        start = (WIDTH - len(parts) * (BOX[0] + GAP) + GAP) / 2 + BOX[0] / 2
        found |= {
            part: (start + k * (BOX[0] + GAP), 24 + row * ROW) for k, part in enumerate(parts)
        }
    return found


def drawn() -> str:
    """The picture."""
    edges = {(layer(one.importer), layer(one.imported)) for one in imports(ROOT) if one.own}
    known = {part for row in LAYERS for part in row}
    graph = networkx.transitive_reduction(
        networkx.DiGraph((a, b) for a, b in edges if a != b and {a, b} <= known)
    )
    at = places()
    lines = [
        f'<line x1="{at[a][0]:.0f}" y1="{at[a][1] + BOX[1] / 2:.0f}" x2="{at[b][0]:.0f}" '
        f'y2="{at[b][1] - BOX[1] / 2 - 3:.0f}"/>'
        for a, b in sorted(graph.edges)
    ]
    boxes = []
    for part, (x, y) in at.items():
        title = (
            "haptic_tracing" if part == "__init__" else part.replace("_", " ").replace(".", " / ")
        )
        colour = COLOURS.get(part.split(".")[0], "#666")
        boxes.append(
            f'<rect x="{x - BOX[0] / 2:.0f}" y="{y - BOX[1] / 2:.0f}" width="{BOX[0]}" '
            f'height="{BOX[1]}" rx="4" fill="{colour}"/>'
            f'<text x="{x:.0f}" y="{y + 4:.0f}">{title}</text>'
        )
    tip = (
        '<marker id="tip" viewBox="0 0 8 8" refX="6" refY="4" markerWidth="6" markerHeight="6" '
        'orient="auto">'
    )
    tip += '<path d="M0 0L8 4L0 8z" fill="#888"/></marker>'
    size = f'viewBox="0 0 {WIDTH} {24 + len(LAYERS) * ROW - 8}"'
    body = "\n".join([f"<style>{STYLE}</style><defs>{tip}</defs>", *lines, *boxes])
    return f'<svg xmlns="http://www.w3.org/2000/svg" {size}>\n{body}\n</svg>\n'


if __name__ == "__main__":
    (HERE / "layers.svg").write_text(drawn(), encoding="utf-8")
