"""The films and tracks of a study with people, rendered once from Blender's scenes."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import Any

import bpy

from ..addon.changes.suspension import suspended
from ..core.forms import Form
from ..pictures.picture import starts_gpu
from ..study.people.plan import stimuli
from .setting import assign
from .trace import open_file, start_blender

_WEBM = (
    "scene.render.image_settings.file_format=FFMPEG",
    "scene.render.ffmpeg.format=WEBM",
    "scene.render.ffmpeg.codec=WEBM",
    "scene.render.use_file_extension=false",
)


def prepare(folder: Path, form: Form) -> None:
    """Write the films and tracks that are missing: films in this process, tracks by `haptic-tracing
    export`. Raises ValueError."""
    start_blender()
    for (name, condition), path in stimuli(folder, form).items():
        section = form["scenes"][name]
        if path.exists():
            continue
        if "tracks" in section or ("film" in section and not condition):
            raise ValueError(f"{path}: there is no such file")
        path.parent.mkdir(parents=True, exist_ok=True)
        blend = folder / section.get("blend", f"stimuli/{section.get('sample')}.blend")
        if "sample" in section and not blend.exists():
            _haptic_tracing("sample", section["sample"], "--output", blend)
        if not condition:
            _render(blend, path, form.get("film_settings", ()), section)
            continue
        options = [f"--set={one}" for one in form["conditions"][condition].get("settings", ())]
        if "frames" in section:
            options.append("--frames={}:{}".format(*section["frames"]))
        _haptic_tracing(
            "export",
            blend,
            "--to",
            "wav",
            "--out",
            path.parent,
            "--absolute",
            "--option=wav.encoding=float32",
            *options,
        )


def _haptic_tracing(*arguments: Any) -> None:
    """Run a command of this program. Raises ValueError where it fails."""
    command = [sys.executable, "-m", "haptic_tracing", *map(str, arguments)]
    if subprocess.run(command).returncode:
        raise ValueError(f"haptic-tracing {arguments[0]} has failed")


def _render(blend: Path, film: Path, settings: list[str], section: Form) -> None:
    """Render a film of a section, as its camera and engine show it."""
    scene = open_file(str(blend))
    render = scene.render
    if hasattr(render.image_settings, "media_type"):
        render.image_settings.media_type = "VIDEO"
    for setting in (*_WEBM, *settings):
        assign(scene, setting)
    if render.engine != "CYCLES" and not starts_gpu():
        raise ValueError(
            f"{film.stem}: {render.engine} needs OpenGL; give the scene a film, or add "
            '"scene.render.engine=CYCLES" to film_settings'
        )
    if "frames" in section:
        scene.frame_start, scene.frame_end = section["frames"]
    part = film.with_name(f"part of {film.name}")
    render.filepath = str(part)
    with suspended():
        bpy.ops.render.render(animation=True)
    part.replace(film)
