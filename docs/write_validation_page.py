"""Compares the model with published measurements and printed answers: writes docs/validation.md and
its pictures, and prints a line for each series.

python docs/write_validation_page.py [FOLDER]      (`make validate`)
"""

from __future__ import annotations

import sys
from pathlib import Path

from haptic_tracing.study.validation import all_series
from haptic_tracing.study.validation_page import body_picture, page, picture


def main(folder: Path) -> None:
    """Write the page and the pictures into a folder."""
    for series in all_series():
        print(f"{series.verdict:7}  {series.kind:10}  {series.name}")
    pictures = folder / "pictures"
    pictures.mkdir(parents=True, exist_ok=True)
    (folder / "validation.md").write_text(page(), encoding="utf-8")
    (pictures / "validation.svg").write_text(picture(), encoding="utf-8")
    (pictures / "body.svg").write_text(body_picture(), encoding="utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1]) if sys.argv[1:] else Path(__file__).parent)
