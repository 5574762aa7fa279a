"""What strangers may feed the product with, and how such inputs are changed at random: files,
formulas, texts stored in a .blend, messages.

A target takes bytes, says whether they were accepted or refused in one clear message, and raises
what it did not expect.
"""

from __future__ import annotations

import copy
import gzip
import io
import json
import math
import random
import tempfile
from collections.abc import Callable, Mapping
from contextlib import chdir, redirect_stderr, redirect_stdout
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from haptic_tracing.addon.properties.actuators import choice_of, places_of
from haptic_tracing.addon.scene_reader import kept_impacts, kept_signal
from haptic_tracing.command_line import build_parser, main, part_file
from haptic_tracing.command_line.serve.conversation import Conversation
from haptic_tracing.command_line.sweep import study
from haptic_tracing.core.devices.connection import DeviceError
from haptic_tracing.core.devices.profile_files import BUILT_IN, parse_profile
from haptic_tracing.core.formats import haptic_scene, registry
from haptic_tracing.core.formats.io import catalogue
from haptic_tracing.core.formats.io.error import FormatError
from haptic_tracing.core.propagation import Propagation
from haptic_tracing.core.scene.functions.checking import check_expression
from haptic_tracing.core.scene.functions.modulation import Expression
from haptic_tracing.core.scene.values import Listener, Source
from haptic_tracing.plugins.players import network
from haptic_tracing.plugins.players.loopback import Player, messages_of

CORPUS = Path(__file__).parents[2] / "core" / "formats" / "corpus"
CRASHERS = Path(__file__).with_name("crashers")
"""Inputs that once got through, as ``TARGET.NUMBER``; those for readers of files are in the corpus
of the formats."""


@dataclass(frozen=True, slots=True)
class Target:
    """seeds: good and bad inputs to begin with. run: takes an input and a folder to write to, and
    returns whether it is accepted."""

    seeds: tuple[bytes, ...]
    run: Callable[[bytes, Path], bool]


def read_file(name: str, content: bytes, folder: Path) -> bool:
    path = folder / name
    path.write_bytes(content)
    try:
        result: Any = (
            haptic_scene.read_export(path)
            if name.endswith((".json", ".json.gz"))
            else registry.read(path)
        )
    except FormatError as error:
        text = str(error)
        assert text.startswith(f"{path}: ") and text.isprintable() and len(text) < 1000, text
        return False
    for channel in getattr(result, "channels", ()):
        assert np.isfinite(channel.duration)
        assert np.isfinite(channel.samples).all()
    return True


def read_formula(content: bytes, folder: Path) -> bool:
    text = content.decode("utf-8", "surrogateescape")
    check_expression(text, on_contact=True)
    try:
        function = Expression(expression=text)
        gains = function.gain(np.linspace(0.0, 10.0, 7), 0.1, 0.9, 0.1)
    except ValueError:
        return False
    assert np.isfinite(gains).all() and gains.min() >= 0, gains
    return True


def read_stored(reader: Callable[[str], Any], content: bytes, folder: Path) -> bool:
    try:
        return (
            reader(content.decode("utf-8", "surrogatepass" if b"\xed" in content else "replace"))
            is not None
        )
    except UnicodeDecodeError:
        return False  # no text: Blender has no such property
    except ValueError as error:
        assert len(str(error)) < 1000, error
        return False


def read_choice(content: bytes, folder: Path) -> bool:
    """Actuators chosen for a listener: what names none is refused without a message."""
    places = places_of(content.decode("utf-8", "replace"))
    assert places is None or places_of(choice_of(places)) == places or not places
    return bool(places)


def read_profile(content: bytes, folder: Path) -> bool:
    try:
        parse_profile(content, "pad.json")
    except FormatError as error:
        assert str(error).startswith("pad.json: ") and len(str(error)) < 1000, error
        return False
    return True


def read_message(content: bytes, folder: Path) -> bool:
    """What Intiface says, as far as it becomes devices and orders to them."""
    try:
        for kind, message in messages_of(content):
            if kind == "ServerInfo":
                seconds = network.ping_seconds(message)
                assert seconds is None or 0.003 < seconds <= 1200.0
            if kind == "DeviceList":
                for profile, _ in network.devices_of(Player(network.INTIFACE, print, b""), message):
                    profile.family.encode(profile.family.silence(), "usb", 0)
                    assert 0.0 < profile.interval("usb") <= 10.0
    except (ValueError, DeviceError) as error:
        assert len(str(error)) < 1000, error
        return False
    return True


def read_bake_part(content: bytes, folder: Path) -> bool:
    path = folder / "x.npz"
    path.write_bytes(content)
    try:
        part = part_file.read_part(path)
    except FormatError as error:
        text = str(error)
        assert text.startswith(f"{path}: ") and text.isprintable() and len(text) < 1000, text
        return False
    assert all(np.isfinite(frame.propagation.gain).all() for frame in part.frames)
    return True


def repacked_part(content: bytes, generator: random.Random) -> bytes:
    """A part with its header changed as a document, or with one of its arrays replaced."""
    with np.load(io.BytesIO(content)) as archive:
        arrays = {name: archive[name] for name in archive.files}
    if generator.random() < 0.6:
        header = json.loads(arrays["header"].tobytes())
        for _ in range(generator.randint(1, 3)):
            _change_document(header, generator)
        arrays["header"] = np.frombuffer(
            json.dumps(header).encode("utf-8", "replace"), dtype=np.uint8
        )
    else:
        name = generator.choice(sorted(arrays))
        shape = tuple(
            max(0, side + generator.choice((-1, 0, 0, 1, 5))) for side in arrays[name].shape
        )
        value = generator.choice((0, 1, -1, 2**62, 1e300, math.nan))
        kind = generator.choice(
            (arrays[name].dtype, np.dtype("<f8"), np.dtype("<i8"), np.dtype("S3"))
        )
        with np.errstate(all="ignore"):
            arrays[name] = np.full(shape, np.array(value).astype(kind))
    packed = io.BytesIO()
    np.savez_compressed(packed, **arrays)
    return packed.getvalue()


def read_sweep(content: bytes, folder: Path) -> bool:
    path = folder / "x.toml"
    path.write_bytes(content)
    (folder / "bench.blend").touch()
    try:
        study.read_study(path)
    except FormatError as error:
        assert str(error).startswith(f"{path}: ") and len(str(error)) < 1000, error
        return False
    return True


def run_command(content: bytes, folder: Path) -> bool:
    """A command line, its words separated by zeros: run if the command needs neither Blender nor a
    device, else only parsed."""
    words = content.decode("utf-8", "surrogateescape").split("\0")
    for name in ("scene.json", "track.hjif"):
        (folder / name).write_bytes(FILES[name])
    said = io.StringIO()
    with chdir(folder), redirect_stdout(io.StringIO()), redirect_stderr(said):
        if words[0] in COMMANDS and not any(".." in word or "/" in word for word in words):
            code = main(words)
        else:
            try:
                build_parser().parse_args(words)
                code = 0
            except SystemExit as end:
                code = end.code or 0
    assert code in (0, 2), (code, words)
    assert code == 0 or len(said.getvalue().splitlines()) == 1 or "--help" in said.getvalue(), (
        said.getvalue()[:500]
    )
    return code == 0


def talk_to_server(content: bytes, folder: Path) -> bool:
    """What a client says to the run-time server, after a scene."""
    conversation = Conversation(None, None)
    conversation.answer(
        json.dumps({"type": "hello", "version": 1, "scene": json.loads(FILES["scene.json"])})
    )
    answers = conversation.answer(content)
    texts = [answer for answer in answers if isinstance(answer, dict)]
    assert all(len(json.dumps(answer, allow_nan=False)) < 1_000_000 for answer in texts)
    return not any(answer["type"] == "error" for answer in texts)


STORED: Mapping[str, tuple[Callable[[str], Any], tuple[dict[str, Any], ...]]] = {
    "signal": (kept_signal.signal_of_text, ({"signal": "sine", "frequency": 60},)),
    "impacts": (
        partial(kept_impacts.impacts_from_text, frame=3, names=("a", "b"), motion="m"),
        (
            {
                "frame": 3,
                "motion": "m",
                "start": 0.1,
                "impacts": [
                    {
                        "objects": ["a", "b"], "time": 0.1, "positions": [[0, 0, 0], [0, 0, 0]], "normal": [0, 0, 1], "energy": 1,
                        "amplitude": 0.5, "estimated": True, "local": [[0, 0, 0], [0, 0, 0]], "poses": [[1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0]] * 2,
                    }
                ],
            },
        ),
    ),
}  # fmt: skip
FORMULAS = (
    "x * exp(-0.2 * d)",
    "exp(-(1 - kappa) * rho * d)",
    "min(1, area / (1 + d ** 2)) if d > 1 else 0.5",
    "abs(cos(angle)) * depth",
)
MESSAGES = (
    [{"ServerInfo": {"Id": 1, "MaxPingTime": 0}}],
    [{"DeviceList": {"Id": 2, "Devices": [{"DeviceIndex": 0, "DeviceName": "Cushion", "DeviceMessageTimingGap": 100,
      "DeviceMessages": {"ScalarCmd": [{"StepCount": 20, "ActuatorType": "Vibrate"}]}}]}}],
    [{"Error": {"Id": 1, "ErrorMessage": "no"}}],
)  # fmt: skip


COMMANDS = ("propagate", "convert", "export")
FILES = {
    "scene.json": (CORPUS / "good-scene.json").read_bytes(),
    "track.hjif": (CORPUS / "good.hjif").read_bytes(),
}
LINES = (
    "propagate scene.json --strategy as_in_the_paper --threshold 0.1",
    "propagate scene.json --max-connections 3 --threshold 0.01 --felt",
    "propagate scene.json --contacts",
    "convert track.hjif out.wav",
    "convert track.hjif out.ahap",
    "export scene.json --to hjif,wav --out out",
    "devices encode dualsense --transport bt --left 0.5 --right 0.25 --sequence 3",
    "export ride.blend --frames 1:36 --part 1/20 --out parts --to wav",
    "sweep study.toml --workers 2 --out out",
    "export parts --to wav,hjif --out out",
)
SWEEP = """scenes = ["bench.blend"]
frames = [1, 12]
modes = ["HT", "SD"]
seeds = [1, 2, 3]
[settings]
"scene.haptics.minimum_energy" = [0.0, 0.001]
[materials]
Floor = ["concrete", "softwood"]
[random]
'objects["Seat"].haptics.kappa' = [0.05, 0.5]
"""
SAID = (
    {"type": "step", "id": 7, "time": 0.1, "samples": True},
    {
        "type": "step",
        "time": 0.2,
        "poses": {"crate": [0, 0, 1, 1, 0, 0, 0]},
        "sources": {"drill": {"amplitude": 0.5}},
    },
    {"type": "step", "time": 0.2, "poses": {"crate": [0, 0, 1, 1, 1e308, 0, 0]}},
    {"type": "add", "object": {"name": "box", "kappa": 0.1, "rho": 0.5}},
    {"type": "remove", "listener": "hand"},
    {"type": "stop"},
)


def small_part() -> bytes:
    """A part of two frames, and the one with which they end."""
    sources = Source("saw", "box", (0.0, 0.0, 0.0), 0.3), Source("hit", "box", (0.0, 0.0, 0.0), 0.1)
    gains = Propagation.of_gains(np.full((2, 1), 0.5), None, np.full((2, 1), 0.01))
    frames = tuple(
        part_file.HeardFrame(
            n, n / 24, sources, (Listener("hand", "box", (0.0, 0.0, 0.0), radius=0.0),), gains
        )
        for n in (1, 2, 3)
    )
    origin = part_file.Origin(
        "any", "any.blend", "0" * 64, "HT", (), (1, 2), 1, part_file.programs()
    )
    with tempfile.TemporaryDirectory() as folder:
        part_file.write_part(
            part_file.Part(origin, 1, 8000.0, "", "after", frames), Path(folder) / "part.npz"
        )
        return (Path(folder) / "part.npz").read_bytes()


def _texts(*documents: Any) -> tuple[bytes, ...]:
    return tuple(json.dumps(document).encode() for document in documents)


def _contents(files: list[Path], ending: str) -> tuple[bytes, ...]:
    """What the corpus has in a format, good files as often as bad ones: few changes leave a file
    good."""
    good, bad = (
        [path.read_bytes() for path in files if path.match(f"{kind}*{ending}")]
        for kind in ("good", "bad")
    )
    return (*good * max(1, len(bad) // len(good)), *bad)


def targets() -> dict[str, Target]:
    """All targets by name."""
    endings = (".json", ".json.gz", *catalogue.readers())
    files = [
        path
        for path in sorted(CORPUS.iterdir())
        if path.name.endswith(endings) and ".wav." not in path.name
    ]
    found = {
        f"file{ending}": Target(_contents(files, ending), partial(read_file, f"x{ending}"))
        for ending in endings
    }
    found |= {
        f"stored-{kind}": Target(_texts(*seeds), partial(read_stored, reader))
        for kind, (reader, seeds) in STORED.items()
    }
    found["formula"] = Target(tuple(text.encode() for text in FORMULAS), read_formula)
    found["choice"] = Target((b"dualsense/left*0.5;switch-pro/right", b"-", b""), read_choice)
    found["profile"] = Target(
        tuple(path.read_bytes() for path in sorted(BUILT_IN.glob("*.json"))), read_profile
    )
    found["message"] = Target(_texts(*MESSAGES), read_message)
    found["part"] = Target((small_part(),), read_bake_part)
    found["sweep"] = Target((SWEEP.encode(),), read_sweep)
    found["command"] = Target(
        tuple(line.replace(" ", "\0").encode() for line in LINES), run_command
    )
    found["server"] = Target(_texts(*SAID), talk_to_server)
    return found


_STRANGE = (
    None,
    True,
    -1,
    0,
    1e308,
    -1e-308,
    10**400,
    "",
    "a" * 3000,
    "\ud800",
    "\u202e\0",
    [],
    {},
    [[]],
    math.nan,
    math.inf,
    2**63,
    "x",
)
_TOKENS = (
    *(b"0", b"-", b"e9", b"1e999", b"[" * 50, b"{", b'"', b",", b"\xff", b"\0" * 4),
    *(b"**", b"(", b"9" * 40, b"NaN", b"\xed\xa0\x80", b"d", b"/"),
)


def changed(seeds: tuple[bytes, ...], generator: random.Random) -> bytes:
    """One of the seeds, changed at one to four places: as a document where it is one, else as
    bytes."""
    content = generator.choice(seeds)
    if content[:4] == b"PK\3\4" and generator.random() < 0.7:
        return repacked_part(content, generator)
    packed = content[:2] == b"\x1f\x8b" and generator.random() < 0.8
    if packed:
        try:
            content = gzip.decompress(content)
        except (OSError, EOFError):
            packed = False
    document = _parsed(content) if generator.random() < 0.6 else None
    for _ in range(generator.randint(1, 4)):
        if isinstance(document, dict | list):
            _change_document(document, generator)
        else:
            content = _change_bytes(content, seeds, generator)
    if isinstance(document, dict | list):
        content = json.dumps(document).encode()
    return gzip.compress(content, 1, mtime=0) if packed else content


def _parsed(content: bytes) -> Any:
    try:
        return json.loads(content)
    except (ValueError, RecursionError):
        return None


def _change_document(document: Any, generator: random.Random) -> None:
    """Replace, remove or copy a value somewhere in the document, the deeper the rarer."""
    holder = document
    while True:
        keys = list(holder) if isinstance(holder, dict) else list(range(len(holder)))
        if not keys:
            return
        key = generator.choice(keys)
        inside = holder[key]
        if not isinstance(inside, dict | list) or not inside or generator.random() < 0.15:
            break
        holder = inside
    match generator.randrange(5):
        case 0:
            del holder[key]
        case 1 if isinstance(holder, dict):
            holder[generator.choice(("kind", "name", "extras", "a\nb", key + "s"))] = inside
        case 1:
            holder.insert(generator.randint(0, len(holder)), inside)
        case 2 if type(inside) is int and abs(inside) < 2**53 and generator.random() < 0.3:
            holder[key] = float(inside)
        case 2 if isinstance(inside, float) or (isinstance(inside, int) and abs(inside) < 2**63):
            holder[key] = inside * generator.choice((-1, 0, 1e-9, 1e9, 1e300, 0.5))
        case 3 if isinstance(holder, list):
            holder.extend([inside] * generator.choice((1, 100)))
        case _:
            holder[key] = copy.deepcopy(generator.choice(_STRANGE))


def _change_bytes(content: bytes, seeds: tuple[bytes, ...], generator: random.Random) -> bytes:
    place = generator.randint(0, len(content))
    before, after = content[:place], content[place:]
    match generator.randrange(6):
        case 0:
            return before + bytes([generator.randrange(256)]) + after[1:]
        case 1:
            return before + after[generator.randint(1, 20) :]
        case 2:
            return before + generator.choice(_TOKENS) + after
        case 3:
            return before + after[:30] + after
        case 4:
            other = generator.choice(seeds)
            return before + other[generator.randint(0, len(other)) :]
        case _:
            return (
                before + bytes(generator.choice((0, 255, 0x7F, 0x80)) for _ in range(4)) + after[4:]
            )
