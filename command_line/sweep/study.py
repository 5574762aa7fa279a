"""A study: a TOML file that defines the variants of scenes to be traced, see docs/scale.md."""

from __future__ import annotations

import hashlib
import json
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from itertools import product
from pathlib import Path
from typing import Any

from ...core.scene.materials import MATERIALS
from ...core.scene.values import Mode
from ..part_file import checksum_of

MOST_VARIANTS = 100_000
_MAX_BYTES = 2**20
_KEYS = frozenset({"scenes", "frames", "modes", "seeds", "settings", "materials", "random"})

Value = bool | int | float | str


@dataclass(frozen=True, slots=True)
class Variant:
    """One scene with its settings by path and materials by object. ``frames``: None for the scene's; ``mode``: None for the file's."""

    scene: str
    blend: str
    frames: tuple[int, int] | None
    mode: str | None
    seed: int | None
    settings: Mapping[str, Value]
    materials: Mapping[str, str]

    def key(self, programs: str) -> str:
        """The name of its result: a checksum of everything that determines it, without the path of the file."""
        inputs = {**asdict(self), "scene": Path(self.scene).name, "programs": programs}
        return hashlib.sha256(json.dumps(inputs, sort_keys=True).encode()).hexdigest()[:32]

    def parameters(self) -> dict[str, Value]:
        """The varied parameters by the names of the table's columns."""
        fixed: dict[str, Value] = {"scene": Path(self.scene).stem}
        fixed |= {} if self.mode is None else {"mode": self.mode}
        fixed |= {} if self.seed is None else {"seed": self.seed}
        return {**fixed, **self.settings, **{f"material of {name}": material for name, material in self.materials.items()}}


@dataclass(frozen=True, slots=True)
class Study:
    """Lists of values: every combination is a variant. ``random``: least and greatest value by path, of which each seed draws one."""

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
        axes = (self.modes or (None,), self.seeds or (None,), product(*self.settings.values()), product(*self.materials.values()))
        rest = list(product(*axes))
        for scene in self.scenes:
            for mode, seed, values, materials in rest:
                drawn = {} if seed is None else {path: _drawn(seed, path, *ends) for path, ends in self.random.items()}
                settings = {**dict(zip(paths, values, strict=True)), **drawn}
                made_of = dict(zip(objects, materials, strict=True))
                yield Variant(str(scene), blends[scene], self.frames, mode, seed, settings, made_of)


def read_study(path: Path) -> Study:
    """Read a study. Raises ValueError that names the key, and OSError."""
    if path.stat().st_size > _MAX_BYTES:
        raise ValueError(f"{path}: larger than {_MAX_BYTES} bytes")
    try:
        form = tomllib.loads(path.read_text(encoding="utf-8"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError, RecursionError) as error:
        raise ValueError(f"{path}: not TOML: {error}") from None
    try:
        study = _study(form, path.parent)
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from None
    return study


def _study(form: Mapping[str, Any], folder: Path) -> Study:
    unknown = sorted(form.keys() - _KEYS)
    if unknown:
        raise ValueError(f"{unknown[0]}: unknown; known are {', '.join(sorted(_KEYS))}")
    scenes = tuple((folder / name).resolve() for name in _listed(form, "scenes", str))
    if not scenes:
        raise ValueError("scenes: name at least one .blend file")
    for scene in scenes:
        if not scene.is_file():
            raise ValueError(f"scenes: there is no file {scene}")
    frames = tuple(_listed(form, "frames", int))
    if frames and not (len(frames) == 2 and 1 <= frames[0] < frames[1] <= 1_048_574):
        raise ValueError("frames: must be [FIRST, LAST] with 1 <= FIRST < LAST")
    modes = tuple(_listed(form, "modes", str))
    for mode in modes:
        if mode not in list(Mode):
            raise ValueError(f"modes: must be some of {', '.join(Mode)}, not {mode}")
    settings, materials, random = (_table(form, name) for name in ("settings", "materials", "random"))
    for name, values in materials.items():
        for material in values:
            if material not in MATERIALS:
                raise ValueError(f"materials: {name}: must be some of {', '.join(MATERIALS)}, not {material}")
    for path, ends in random.items():
        if not (len(ends) == 2 and all(type(end) in (int, float) for end in ends) and ends[0] <= ends[1]):
            raise ValueError(f"random: {path}: must be [LEAST, GREATEST]")
        if path in settings:
            raise ValueError(f"random: {path}: is among the settings as well")
    seeds = tuple(_listed(form, "seeds", int))
    if random and not seeds:
        raise ValueError("seeds: [random] draws one value for each seed: list some")
    study = Study(scenes, (frames[0], frames[1]) if frames else None, modes, seeds, settings, materials, random)
    if study.count > MOST_VARIANTS:
        raise ValueError(f"{study.count} variants are more than {MOST_VARIANTS}")
    return study


def _listed(form: Mapping[str, Any], name: str, kind: type) -> list[Any]:
    values = form.get(name, [])
    if not isinstance(values, list) or any(type(value) is not kind for value in values):
        raise ValueError(f"{name}: must be a list of {'texts' if kind is str else 'whole numbers'}")
    return list(dict.fromkeys(values))


def _table(form: Mapping[str, Any], name: str) -> dict[str, list[Any]]:
    table = form.get(name, {})
    if not isinstance(table, dict):
        raise ValueError(f"{name}: must be a table of lists")
    for key, values in table.items():
        if not isinstance(values, list) or not values or any(type(value) not in (bool, int, float, str) for value in values):
            raise ValueError(f"{name}: {key}: must be a list of values")
    return {key: list(dict.fromkeys(values)) if name != "random" else values for key, values in table.items()}


def _drawn(seed: int, path: str, least: float, greatest: float) -> float:
    """A uniformly distributed value between the ends, from SHA-256 of seed and path, the same on every machine."""
    share = int.from_bytes(hashlib.sha256(f"{seed} {path}".encode()).digest()[:8]) / 2**64
    return least + (greatest - least) * share
