"""The rules of each format that its schema can't say: those of a plug-in are in `rules.py` beside
its tests."""

import importlib.util
import json
import struct
from pathlib import Path

import haptic_tracing
from haptic_tracing.core.formats.io.schema import load_schema, validate
from jsonschema import Draft7Validator

PLUGINS = Path(haptic_tracing.__file__).parent / "plugins"
LARGE = 300_000  # bytes, from which on jsonschema is given a rest


def _rules():
    """Schema and check of a file, by its ending."""
    found = {}
    for path in sorted(Path(__file__).parents[2].glob("plugins/*/rules.py")):
        spec = importlib.util.spec_from_file_location(f"rules_of_{path.parent.name}", path)
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        for suffix, (schema, check) in module.RULES.items():
            found[suffix] = PLUGINS / path.parent.name / f"{schema}.schema.json", check
    return found


RULES = _rules()
VALIDATORS = {suffix: Draft7Validator(load_schema(schema)) for suffix, (schema, _) in RULES.items()}


def check_wav(data, channels, count, rate):
    assert (
        data[:4] == b"RIFF"
        and data[8:16] == b"WAVEfmt "
        and struct.unpack("<I", data[4:8])[0] == len(data) - 8
    )
    size, tag, wave_channels, wave_rate, bytes_a_second, frame, bits, extra = struct.unpack(
        "<IHHIIHHH", data[16:38]
    )
    assert (size, tag, wave_channels, wave_rate, extra) == (40, 0xFFFE, channels, rate, 22)
    assert frame == channels * bits // 8 and bytes_a_second == rate * frame
    code = struct.unpack("<H", data[44:46])[0]
    assert code == {16: 1, 32: 3}[bits] and data[46:60] == bytes.fromhex(
        "000000001000800000aa00389b71"
    )
    place = data.index(b"data", 60)
    assert (
        struct.unpack("<I", data[place + 4 : place + 8])[0]
        == len(data) - place - 8
        == count * frame
    )


def check_file(path, tracks):
    """Schema and rules of a written file."""
    suffix = path.suffix
    if suffix in RULES:
        schema, check = RULES[suffix]
        document = json.loads(path.read_bytes())
        if path.stat().st_size < LARGE:
            errors = [
                f"{list(error.path)}: {error.message[:200]}"
                for error in VALIDATORS[suffix].iter_errors(document)
            ]
            assert not errors, (path.name, errors[:3])
        else:
            validate(document, schema, path)
        check(document, path, tracks)
    elif suffix == ".wav":
        check_wav(path.read_bytes(), len(tracks.listeners), tracks.count, tracks.sample_rate)
