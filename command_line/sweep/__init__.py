"""``haptic-tracing sweep STUDY.toml``: traces many variants of scenes in parallel, on this machine
or on a Dask cluster; ``sweep plot`` draws and queries the resulting table."""

from __future__ import annotations

import argparse
import shutil
from dataclasses import asdict
from importlib import import_module
from pathlib import Path
from typing import Any

from tqdm import tqdm

from .. import answer
from ..part_file import programs

NEEDS = "pip install '.[sweep]' in a copy of this project"


def run(args: argparse.Namespace) -> int:
    """Trace all variants that have no result yet and write the table; or draw one. Exit code 0."""
    if args.study[0] == "plot":
        if len(args.study) != 2:
            raise ValueError("sweep plot: name one table")
        code: int = _needing("plot").run(args, Path(args.study[1]))
        return code
    if len(args.study) != 1:
        raise ValueError("sweep: name one study")
    if args.workers < 1:
        raise ValueError(f"--workers: must be 1 or more, not {args.workers}")
    return _sweep(args, Path(args.study[0]))


def _needing(name: str) -> Any:
    """A module of this package. Raises ValueError with the package to install if it cannot be
    imported."""
    try:
        return import_module(f".{name}", __name__)
    except ModuleNotFoundError as error:
        if error.name not in ("dask", "distributed", "pyarrow", "matplotlib"):
            raise
        raise ValueError(f"this needs {error.name}: {NEEDS}") from None


def _sweep(args: argparse.Namespace, path: Path) -> int:
    table, study_file, checking = (_needing(name) for name in ("table", "study", "checking"))
    study = study_file.read_study(path)
    size = checking.check(study)
    folder = args.out / path.stem
    _make_folders(folder, study.count, size if args.tracks else 0.0)
    versions = programs()
    keyed = list({variant.key(versions): variant for variant in study.variants()}.items())
    open_ = [(key, variant) for key, variant in keyed if not _is_done(folder, key, args.tracks)]
    tasks = [
        {
            "key": key,
            "variant": asdict(variant),
            "folder": str(folder.resolve()),
            "tracks": args.tracks,
        }
        for key, variant in open_
    ]
    failures = {}
    with tqdm(
        total=len(keyed),
        initial=len(keyed) - len(open_),
        desc=path.stem,
        unit="variant",
        disable=None,
    ) as bar:
        for key, failure in (
            _needing("scheduling").run_all(args.on, args.workers, tasks) if tasks else ()
        ):
            if failure:
                failures[key] = failure
            bar.update()
    table.write_table(folder.with_suffix(".parquet"), folder, keyed)
    print(
        f"wrote {folder.with_suffix('.parquet')}: {len(keyed) - len(failures)} variants, "
        f"{len(open_)} of them new"
    )
    if failures:
        key, reason = next(iter(failures.items()))
        raise ValueError(f"{len(failures)} of {len(keyed)} variants failed, {key}: {reason}")
    answer(
        args,
        {
            "files": [str(folder.with_suffix(".parquet"))],
            "variants": len(keyed),
            "new": len(open_),
        },
    )
    return 0


def _make_folders(folder: Path, variants: int, tracks: float) -> None:
    """The folders of results. Raises ValueError if the disk has not enough space, and OSError."""
    for name in ("results", "tracks"):
        (folder / name).mkdir(parents=True, exist_ok=True)
    needed, free = _RESULT_BYTES * variants + tracks, shutil.disk_usage(folder).free
    if needed > free:
        raise ValueError(
            f"{folder}: {variants} variants need about {needed / 1e6:.3g} MB, and "
            f"{free / 1e6:.3g} MB are free"
        )


_RESULT_BYTES = 16_384
"""Size of a result and its rows in the table."""


def _is_done(folder: Path, key: str, tracks: bool) -> bool:
    return (folder / "results" / f"{key}.json").exists() and (
        not tracks or (folder / "tracks" / f"{key}.wav").exists()
    )
