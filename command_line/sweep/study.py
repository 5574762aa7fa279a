"""A study: a TOML file that defines the variants of scenes to be traced, see docs/scale.md."""

from __future__ import annotations

import hashlib
import json
import math
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict
from itertools import product
from pathlib import Path
from typing import Any

from ...core.formats.io.error import FormatError, errors_in
from ...core.formats.io.schema import validate
from ...core.formats.io.strict_json import parse_json, read_bytes
from ...core.forms import Form
from ...core.frozen import frozen
from ...core.scene.materials import MATERIALS
from ...core.scene.references import PlacedError
from ...core.scene.values import Mode
from ..part_file import checksum_of

MOST_VARIANTS = 100_000
_MAX_BYTES = 2**20

Value = bool | int | float | str


@frozen
class Variant:
    """One scene with its settings by path and materials by object. ``frames``: None for the
    scene's; ``mode``: None for the file's."""

    scene: str
    blend: str
    frames: tuple[int, int] | None
    mode: str | None
    seed: int | None
    settings: Mapping[str, Value]
    materials: Mapping[str, str]

    def key(self, programs: str) -> str:
        """The name of its result: a checksum of everything that determines it, without the path of
        the file."""
        inputs = {**asdict(self), "scene": Path(self.scene).name, "programs": programs}
        return hashlib.sha256(json.dumps(inputs, sort_keys=True).encode()).hexdigest()[:32]

    def parameters(self) -> dict[str, Value]:
        """The varied parameters by the names of the table's columns."""
        fixed: dict[str, Value] = {"scene": Path(self.scene).stem}
        fixed |= {} if self.mode is None else {"mode": self.mode}
        fixed |= {} if self.seed is None else {"seed": self.seed}
        return {
            **fixed,
            **self.settings,
            **{f"material of {name}": material for name, material in self.materials.items()},
        }


@frozen
class SweepStudy:
    """Lists of values: every combination is a variant. ``random``: least and greatest value by
    path, of which each seed draws one."""

    scenes: tuple[Path, ...]
    frames: tuple[int, int] | None
    modes: tuple[str, ...]
    seeds: tuple[int, ...]
    settings: Mapping[str, Sequence[Value]]
    materials: Mapping[str, Sequence[str]]
    random: Mapping[str, Sequence[float]]

    @property
    def count(self) -> int:
        """Number of variants."""
        count = len(self.scenes) * max(len(self.modes), 1) * max(len(self.seeds), 1)
        for values in (*self.settings.values(), *self.materials.values()):
            count *= len(values)
        return count

    def variants(self) -> Iterator[Variant]:
        """All combinations, in the order of the file."""
        paths, objects = tuple(self.settings), tuple(self.materials)
        blends = {scene: checksum_of(scene) for scene in self.scenes}
        axes = (
            self.modes or (None,),
            self.seeds or (None,),
            product(*self.settings.values()),
            product(*self.materials.values()),
        )
        rest = list(product(*axes))
        for scene in self.scenes:
            for mode, seed, values, materials in rest:
                drawn = (
                    {}
                    if seed is None
                    else {path: _drawn(seed, path, *ends) for path, ends in self.random.items()}
                )
                settings = {**dict(zip(paths, values, strict=True)), **drawn}
                made_of = dict(zip(objects, materials, strict=True))
                yield Variant(str(scene), blends[scene], self.frames, mode, seed, settings, made_of)


def read_study(path: Path) -> SweepStudy:
    """Read a study. Raises FormatError, and OSError."""
    try:
        form = tomllib.loads(read_bytes(path, _MAX_BYTES).decode(), parse_float=_finite)
        document = parse_json(json.dumps(form, default=str).encode(), path)
    except FormatError:
        raise
    except (ValueError, RecursionError) as error:
        raise FormatError(path, "/", f"not TOML: {error}") from None
    validate(document, "sweep", path)
    with errors_in(path):
        return _study(document, path.parent)


def _finite(text: str) -> float:
    if not math.isfinite(value := float(text)):
        raise ValueError(f"{text} is no number of a setting")
    return value


def _study(form: Form, folder: Path) -> SweepStudy:
    """A study from its validated document. Raises PlacedError."""
    scenes = tuple(dict.fromkeys((folder / name).resolve() for name in form["scenes"]))
    for number, scene in enumerate(scenes):
        if not scene.is_file():
            raise PlacedError(("scenes", number), f"there is no file {scene}")
    frames = tuple(map(int, form.get("frames", ())))
    if frames and frames[0] >= frames[1]:
        raise PlacedError(("frames",), "must be [FIRST, LAST] with 1 <= FIRST < LAST")
    for number, mode in enumerate(form.get("modes", ())):
        if mode not in list(Mode):
            raise PlacedError(("modes", number), f"must be one of {', '.join(Mode)}, not {mode}")
    for name, values in form.get("materials", {}).items():
        for material in values:
            if material not in MATERIALS:
                raise PlacedError(
                    ("materials", name), f"must be some of {', '.join(MATERIALS)}, not {material}"
                )
    random = form.get("random", {})
    for path, (least, greatest) in random.items():
        if least > greatest:
            raise PlacedError(("random", path), "must be [LEAST, GREATEST]")
        if path in form.get("settings", {}):
            raise PlacedError(("random", path), "is among the settings as well")
    seeds = tuple(dict.fromkeys(map(int, form.get("seeds", ()))))
    if random and not seeds:
        raise PlacedError(("seeds",), "[random] draws one value for each seed: list some")
    modes = tuple(dict.fromkeys(form.get("modes", ())))
    settings, materials = (
        {key: _distinct(values) for key, values in form.get(name, {}).items()}
        for name in ("settings", "materials")
    )
    study = SweepStudy(
        scenes,
        (frames[0], frames[1]) if frames else None,
        modes,
        seeds,
        settings,
        materials,
        random,
    )
    if study.count > MOST_VARIANTS:
        raise PlacedError((), f"{study.count} variants are more than {MOST_VARIANTS}")
    return study


def _distinct(values: Sequence[Any]) -> list[Any]:
    """The values without repetitions; true is not 1."""
    return list({(type(value), value): value for value in values}.values())


def _drawn(seed: int, path: str, least: float, greatest: float) -> float:
    """A uniformly distributed value between the ends, from SHA-256 of seed and path, the same on
    every machine."""
    share = int.from_bytes(hashlib.sha256(f"{seed} {path}".encode()).digest()[:8]) / 2**64
    return least + (greatest - least) * share
