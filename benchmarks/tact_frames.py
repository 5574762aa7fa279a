"""How ``.tact`` files are read, against the frames that the maker's program rendered into some of
them: a table of the channels below a correlation of 0.99, by file, body part and cause.

    python -m benchmarks.tact_frames FOLDER [--store]

FOLDER: any folder with ``.tact`` files, such as a copy of the maker's plug-in for Unreal Engine 4,
whose older files have frames. A channel is the strongest motor of a body part, frame by frame.
"""

from __future__ import annotations

import argparse
import json
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from haptic_tracing.core.scene.body import BODY_PARTS
from haptic_tracing.plugins.bhaptics import tact
from haptic_tracing.plugins.bhaptics.motors import DEVICES, region
from numpy.typing import NDArray

ENOUGH = 0.99
LAYOUTS = {position: places for layout in DEVICES.values() for position, places in layout.items()}
STORED = Path(__file__).with_name("results") / "tact_frames.md"


def rendered(document: Any, position: str, count: int) -> NDArray[np.float64]:
    """The frames of a position: strengths (motors, count) from 0 to 1."""
    table = np.zeros((len(LAYOUTS[position]), count))
    for time, devices in document["feedback"].items():
        for device in devices:
            if device["position"] == position:
                table[:, int(float(time)) // 20] = np.array(device["values"][: len(table)]) / 100
    return table


def read(document: Any, position: str, count: int) -> NDArray[np.float64]:
    """The same as this program reads them."""
    table = np.zeros((len(LAYOUTS[position]), count))
    for effect in effects_of(document):
        if position in effect["modes"]:
            player = tact._Player(
                table, LAYOUTS[position], effect["startTime"], effect["offsetTime"]
            )
            player.play(effect["modes"][position])
    return np.clip(table, 0.0, 1.0)


def effects_of(document: Any) -> list[Any]:
    """The effects of the tracks that are played."""
    tracks = document["project"]["tracks"]
    return [effect for track in tracks if track.get("enable", True) for effect in track["effects"]]


def channels(document: Any) -> Iterator[tuple[str, float, float, float]]:
    """Body part, correlation, largest difference and largest strength of each channel."""
    length = max(item["startTime"] + item["offsetTime"] for item in effects_of(document))
    count = max(math.floor(length / 20), *(int(float(t)) // 20 for t in document["feedback"])) + 1
    end = math.ceil(length / 20)  # the frame at the end is that of silence
    for position in {device["position"] for now in document["feedback"].values() for device in now}:
        if position not in LAYOUTS:
            continue
        tables = rendered(document, position, count), read(document, position, count)
        for part in BODY_PARTS:
            motors = region(part, LAYOUTS[position])
            if part.bhaptics != position or part.name == "head":
                continue
            theirs, ours = (table[motors, :end].max(axis=0, initial=0.0) for table in tables)
            if theirs.any() or ours.any():
                alike = np.corrcoef(theirs, ours)[0, 1] if theirs.any() and ours.any() else 0.0
                yield part.name, float(alike), float(np.abs(theirs - ours).max()), theirs.max()


def has_single_points(document: Any) -> bool:
    """Whether a path has one point, which those frames left out and today's player plays."""
    return any(
        mode["mode"] == "PATH_MODE" and len(path["pointList"]) == 1
        for effect in effects_of(document)
        for mode in effect["modes"].values()
        for path in mode["pathMode"]["feedback"]
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--store", action="store_true", help="write results/tact_frames.md")
    args = parser.parse_args()
    found, seen, lines = [], set(), []
    for path in sorted(args.folder.rglob("*.tact")):
        document = json.loads(path.read_text("utf-8-sig"))
        content = json.dumps([document.get("feedback"), document["project"]["tracks"]])
        if not document.get("feedback") or content in seen or not effects_of(document):
            continue
        seen.add(content)
        tact._convert_numbers(document)
        single = has_single_points(document)
        for part, alike, difference, strength in channels(document):
            found.append((alike, single))
            if not alike > ENOUGH:
                cause = "a path of one point" if single else "percents rounded down"
                row = path.stem, part, f"{alike:.3f}", f"{difference:.2f}", f"{strength:.2f}", cause
                lines.append(f"| {' | '.join(row)} |")
    other = [alike for alike, single in found if not single]
    text = (
        f"# .tact files against the frames in them\n\n{len(seen)} files, {len(found)} channels. "
        f"Without the files with paths of one point, {sum(alike > ENOUGH for alike in other)} of "
        f"{len(other)} correlate above {ENOUGH:g} (median {np.median(other):.4f}).\n\n"
        "| file | body part | correlation | largest difference | strongest frame | cause |\n"
        "|---|---|---|---|---|---|\n" + "\n".join(lines) + "\n"
    )
    print(text)
    if args.store:
        STORED.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
