"""Build the extension: one zip per platform in dist/ (or in the folder named), by Blender's own
builder and validated by it.

Run it with an interpreter that has the bpy wheel: the builder, blender_ext.py, comes with it.
"""

import importlib.util
import subprocess
import sys
from pathlib import Path

import manual
import wheels

ROOT = wheels.ROOT


def blender_scripts() -> Path:
    """The folder `scripts` of the bpy wheel, found without importing bpy."""
    specification = importlib.util.find_spec("bpy")
    if specification is None or specification.origin is None:
        raise SystemExit(f"{sys.executable} has no bpy; make one with packaging/make_environment")
    (scripts,) = Path(specification.origin).parent.glob("*/scripts")
    return scripts


def extension_command(*arguments: str) -> None:
    """`blender --command extension ARGUMENTS`, without a Blender; ends the program with Blender's
    message where it fails."""
    script = blender_scripts() / "addons_core" / "bl_pkg" / "cli" / "blender_ext.py"
    answer = subprocess.run(
        [sys.executable, str(script), *arguments], capture_output=True, text=True
    )
    if answer.returncode:
        raise SystemExit(f"extension {arguments[0]}: {answer.stdout}{answer.stderr}".strip())


def build(output: Path) -> list[Path]:
    """Write and validate the zips; returns their paths."""
    problems = wheels.missing_wheels()
    if problems:
        raise SystemExit(
            f"missing from wheels/: {', '.join(problems)}; fetch them with packaging/wheels.py"
        )
    manual.write(ROOT / "docs", ROOT / "manual")
    tags = blender_scripts() / "modules" / "_bpy_internal" / "extensions" / "tags.py"
    output.mkdir(parents=True, exist_ok=True)
    for old in output.glob("haptic_tracing-*.zip"):
        old.unlink()
    extension_command(
        "build",
        "--source-dir",
        str(ROOT),
        "--output-dir",
        str(output),
        "--split-platforms",
        "--valid-tags",
        str(tags),
    )
    zips = sorted(output.glob("haptic_tracing-*.zip"))
    for path in zips:
        extension_command("validate", "--valid-tags", str(tags), str(path))
    return zips


if __name__ == "__main__":
    for path in build(Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "dist"):
        print(
            f"{path.relative_to(ROOT) if path.is_relative_to(ROOT) else path}  "
            f"{path.stat().st_size / 1e6:.1f} MB, validated"
        )
