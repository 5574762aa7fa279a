"""``haptic-tracing validate``: compares the model with published measurements, as a page with a
picture."""

from __future__ import annotations

import argparse

from ..study.validation import all_series
from ..study.validation_page import body_picture, page, picture
from . import answer
from .picture import check_matplotlib


def run(args: argparse.Namespace) -> int:
    """Print a line for each series; write the page and its picture if a folder is given. Exit code
    0."""
    series_of_all, files = all_series(), []
    for series in series_of_all:
        print(f"{series.verdict:7}  {series.kind:10}  {series.name}")
    if args.out is not None:
        check_matplotlib("--out")
        (args.out / "pictures").mkdir(parents=True, exist_ok=True)
        pictures = args.out / "pictures"
        for path, text in (
            (args.out / "validation.md", page()),
            (pictures / "validation.svg", picture()),
            (pictures / "body.svg", body_picture()),
        ):
            path.write_text(text, encoding="utf-8")
            print(f"wrote {path}")
            files.append(str(path))
    rows = [
        {"name": series.name, "kind": series.kind, "verdict": series.verdict}
        for series in series_of_all
    ]
    answer(args, {"series": rows, "files": files})
    return 0
