"""``haptic-tracing export FILES --to FORMATS --out FOLDER``: what the listeners of a haptic scene
or of a Blender file feel, in the formats of other programs."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Mapping, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from types import MappingProxyType

from ..core.declaration import Declaration, Number, Switch
from ..core.formats import registry
from ..core.formats.export import Export
from ..core.formats.io.catalogue import SCENE, Value, formats, named
from ..core.formats.io.file_names import file_stem
from ..core.forms import JsonObject
from ..core.plugins import offered
from . import answer, command_module, say
from .picture import check_matplotlib, write_picture
from .standard_streams import DASH, folder, put_out

_ONLY_OF: Mapping[str, tuple[str, tuple[str, ...]]] = MappingProxyType(
    {
        "scene": ("a haptic scene", ("seconds", "sample_rate")),
        "blend": ("a Blender file", ("frames", "modes", "set", "part", "from_start")),
    }
)
"""By the kind of a file what it is, and the arguments that concern no other."""


def run(args: argparse.Namespace) -> int:
    """Read or play each file, write it in each format, and print the losses. Exit code 0."""
    names = chosen_formats(args.to)
    modules = dict(offered("exports"))
    if names[0] in modules:
        return _export_files(args, names, modules)
    options = chosen_options(args.options, names)
    kind = _kind_of(args.files)
    for other, (what, arguments) in _ONLY_OF.items():
        for name in arguments:
            if other != kind and getattr(args, name) not in (None, "", [], False):
                raise ValueError(f"--{name.replace('_', '-')}: only for {what}")
    if args.picture:
        check_matplotlib("--picture")
    module = command_module(f"exported_{kind}")
    if args.part:
        answer(args, {"files": [str(path) for path in module.write_parts(args)]})
        return 0
    results = [_written(export, options, args) for export in module.exports(args, names)]
    if args.out != DASH:
        answer(args, {"exports": results})
    return 0


def _export_files(
    args: argparse.Namespace, names: Sequence[str], modules: Mapping[str, str]
) -> int:
    """Let a plug-in write a Blender file itself, with what Blender shows."""
    if len(names) > 1 or _kind_of(args.files) != "blend" or args.out == DASH:
        raise ValueError(f"--to {names[0]}: only alone, of a Blender file, into a folder")
    files = command_module("exported_blend").write_files(args, modules[names[0]])
    written = {names[0]: registry.Written(tuple(files), ())}
    answer(args, {"exports": [{"name": args.files[0].stem, **report(written)}]})
    return 0


def _kind_of(files: Sequence[Path]) -> str:
    """What the files are: a scene, a Blender file, or parts. Raises ValueError for several of the
    former."""
    if any(path.suffix == ".npz" or path.is_dir() for path in files):
        return "parts"
    if len(files) > 1:
        raise ValueError(
            f"{files[1]}: one scene or Blender file at a time; only parts (*.npz) are several"
        )
    return "blend" if files[0].suffix == ".blend" else "scene"


def _written(
    export: Export, options: Mapping[str, Mapping[str, Value]], args: argparse.Namespace
) -> JsonObject:
    """Write an export in each format, unless only its losses are asked for, and print both; the
    same as JSON values."""
    is_kept = args.absolute or list(options) == [SCENE.name]
    clips, changes = (export, ()) if is_kept else export.as_clips()
    given = {name: export if name == SCENE.name else clips for name in options}
    names = _writable(args.to, given, options)
    result: JsonObject = {"name": export.name, "changes": changes}
    to_stdout = args.out == DASH
    for words in changes:
        print(f"{export.name}: {words}", file=sys.stderr if to_stdout else sys.stdout)
    if args.losses:
        losses = {name: registry.losses(name, given[name], options[name]) for name in names}
        print_losses(losses)
        return result | {"losses": losses}
    target = folder() if to_stdout else args.out
    target.mkdir(parents=True, exist_ok=True)
    written = {
        name: registry.write(name, given[name], target, options[name], may_replace)
        for name in names
    }
    if to_stdout:
        put_out([path for item in written.values() for path in item.files], args.stdout)
        say(loss for item in written.values() for loss in item.losses)
        return result
    if args.picture and export.tracks is not None:
        written = {
            name: _with_picture(name, given[name], item, target) for name, item in written.items()
        }
    result |= report(written)
    if args.methods:
        result["methods"] = export.methods()
        print(result["methods"])
    return result


def report(written: Mapping[str, registry.Written]) -> JsonObject:
    """Print the files of each format and what is not in them; with what each listener loses, as
    JSON values."""
    files = [str(path) for item in written.values() for path in item.files]
    losses = {name: item.losses for name, item in written.items()}
    replaced = {path for item in written.values() for path in item.replaced}
    for path in (path for item in written.values() for path in item.files):
        print(f"replaced {path}" if path in replaced else f"wrote {path}")
    print_losses(losses)
    listeners = {
        name: [asdict(one) for one in item.fidelity.listeners]
        for name, item in written.items()
        if item.fidelity
    }
    return {"files": files, "losses": losses, "listeners": listeners}


def print_losses(losses: Mapping[str, Sequence[str]]) -> None:
    """Print what is not in the files of each format."""
    for name, sentences in losses.items():
        for sentence in sentences:
            print(f"not in {name}: {sentence}")


def may_replace(written: registry.Written) -> bool:
    """Ask on the terminal whether files are replaced by ones that keep little of the vibration;
    True without a terminal."""
    if not (written.is_poor and sys.stdin.isatty()):
        return True
    names = ", ".join(path.name for path in written.files[:3])
    print(
        *written.losses, f"Replace {names}? [y/N] ", sep="\n", end="", file=sys.stderr, flush=True
    )
    return sys.stdin.readline().strip().lower() in ("y", "yes")


def _with_picture(
    name: str, export: Export, written: registry.Written, folder: Path
) -> registry.Written:
    path = write_picture(name, export.need_tracks(), written, folder, file_stem(export.name))
    return written if path is None else replace(written, files=(*written.files, path))


def chosen_formats(text: str) -> list[str]:
    """The formats in ``text``, each once; ``all`` are all of them."""
    return list(formats()) if text == "all" else list(dict.fromkeys(text.split(",")))


def _writable(
    text: str, exports: Mapping[str, Export], options: Mapping[str, Mapping[str, Value]]
) -> list[str]:
    """The formats of ``exports``, as chosen by ``text``; of ``all`` those that can be written, and
    a line for each other one."""
    found = []
    for name, export in exports.items():
        try:
            registry.losses(name, export, options[name])
        except ValueError as error:
            if text != "all":
                raise
            say([f"{name}: {error}"])
        else:
            found.append(name)
    return found


def chosen_options(settings: list[str], names: list[str]) -> dict[str, dict[str, Value]]:
    """The options of each format from ``format.option=value``. Raises ValueError for unknown names
    and values out of range."""
    chosen: dict[str, dict[str, Value]] = {name: {} for name in names}
    known = {name: named(name).options for name in names}
    for setting in settings:
        key, equals, text = setting.partition("=")
        name, _, option = key.partition(".")
        if not equals or option not in known.get(name, {}):
            offered = ", ".join(
                f"{name}.{option}" for name, entries in known.items() for option in entries
            )
            raise ValueError(
                f"{setting}: expected FORMAT.OPTION=VALUE"
                + (f" with one of {offered}" if offered else "")
            )
        try:
            chosen[name][option] = _value_of(known[name][option], text)
        except ValueError as error:
            raise ValueError(f"{setting}: {error}") from None
    return chosen


def _value_of(option: Declaration, text: str) -> Value:
    """The value of an option in a text. Raises ValueError with the reason."""
    value: Value = text
    if isinstance(option, Switch):
        value = {"true": True, "false": False}.get(text.lower(), text)
    elif isinstance(option, Number):
        try:
            value = int(text) if option.whole else float(text)
        except ValueError:
            kind = "whole number" if option.whole else "number"
            raise ValueError(f"must be a {kind}, got {text!r}") from None
    checked: Value = option.checked(value)
    return checked
