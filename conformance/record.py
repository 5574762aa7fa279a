"""Recordings: the poses of objects in Blender, frame by frame, and the levels and impacts that
the add-on gives for them.

python conformance/record.py SAMPLE FIRST LAST      write a sample's recording beside this script

Needs an interpreter that has bpy and the package.
"""

import gzip
import json
import sys
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import bpy
import haptic_tracing
import numpy as np
from haptic_tracing.addon.changes.suspension import suspended
from haptic_tracing.addon.io.frame_scene import written_frame
from haptic_tracing.addon.io.written_objects import WrittenObjects
from haptic_tracing.addon.session import session, timeline
from haptic_tracing.addon.session.sessions import Traced
from haptic_tracing.addon.view.levels import shown_levels
from haptic_tracing.core.contacts.shapes import quaternions, rotation_matrix
from haptic_tracing.core.formats.scene.scene_json import scene_to_dict
from haptic_tracing.core.formats.scene.values_json import item_to_dict
from haptic_tracing.core.render.history import History
from haptic_tracing.core.render.levels import finite
from haptic_tracing.core.tracer import Tracer
from haptic_tracing.sample_scenes import SAMPLES, build_sample

TOLERANCES = {"seconds": 1e-4, "energy": 1e-3}
"""Tolerances of impacts: time [s], and energy relative to what is expected."""
CARRIED = 1e-4
"""How far a source or listener may be from where its object carries it, without a word [m]."""


def recording(scene, first, last):
    """The messages of an engine that has the poses of ``scene``, and the answers that agree with
    the levels, gains and impacts of Blender's frames by these poses, as the messages have them:
    what curves tell between them an engine doesn't know."""
    exchange, pen, tracer, history = [], None, Tracer(), History()
    with closing(timeline.steps(scene, first, last)) as steps:
        for step in steps:
            own = session.of(scene)
            if pen is None:
                pen = _Pen(step.result, own.reading, scene)
                exchange.append(pen.hello())
            tracer.collisions.settings = own.reading.contact_settings
            sent = own.request.frame.transforms.copy()
            sent[:, :3, :3] = rotation_matrix(quaternions(sent[:, :3, :3]))
            result = tracer.step(replace(own.request.frame, motion=None, transforms=sent))
            history.feed(result)
            shown = Traced(result, own.reading.settings, history.all(), own.reading)
            exchange += pen.messages(own.reading, result, shown)
    return exchange


class _Pen:
    """Writes what has changed since the frame before."""

    def __init__(self, result, reading, scene):
        self._objects = WrittenObjects()
        written = written_frame(result, reading, scene, self._objects.of(reading))
        names = {item.name for item in reading.sources}
        self._scene = scene_to_dict(
            replace(written, sources=tuple(s for s in written.sources if s.name in names))
        )
        self._poses = dict(
            zip((item.name for item in reading.objects), reading.transforms, strict=True)
        )
        self._sources = {item.name: item for item in reading.sources}
        self._places = {
            (kind, item.name): self._local(item)
            for kind, items in (("source", reading.sources), ("listener", reading.listeners))
            for item in items
        }
        self._playing = dict.fromkeys(self._sources, True)

    def hello(self):
        return {
            "send": {"type": "hello", "version": 1, "scene": self._scene},
            "expect": {"type": "scene"},
        }

    def messages(self, reading, result, shown):
        """The messages of one frame; the last of them is its step."""
        step = {"type": "step", "time": result.time}
        before = self._poses
        self._poses = dict(
            zip((item.name for item in reading.objects), reading.transforms, strict=True)
        )
        for item in self._objects.of(reading):
            if not np.array_equal(self._poses[item.name], before.get(item.name)):
                pose = [*item.pose.position, *item.pose.rotation]
                step.setdefault("poses", {})[item.name] = pose
        told = list(self._changed(reading.sources, step))
        for kind, items in (("source", reading.sources), ("listener", reading.listeners)):
            for item in items:
                if (kind, item.name) not in self._places:
                    self._places[kind, item.name] = self._local(item)
                if np.abs(self._local(item) - self._places[kind, item.name]).max() > CARRIED:
                    step.setdefault(f"{kind}_positions", {})[item.name] = list(item.position)
        expected = {
            "type": "frame",
            "levels": {
                level.listener: {"level": finite(level.rms)}
                for level in shown_levels(shown, is_playing=True)
            },
            "impacts": [
                {
                    "objects": [reading.bodies[k].name for k in impact.objects],
                    "time": impact.time,
                    "energy": impact.energy,
                }
                for impact in result.impacts
            ],
        }
        return [*told, {"send": step, "expect": expected}]

    def _changed(self, sources, step):
        """Messages on sources that are not as they were; amplitudes are part of the step."""
        now = {item.name: item for item in sources}
        for name, item in now.items():
            known = self._sources.get(name)
            if (
                known is None
                or replace(item, amplitude=known.amplitude, position=known.position) != known
            ):
                kind = "add" if known is None else "replace"
                yield {
                    "send": {"type": kind, "source": item_to_dict(item)},
                    "expect": {"type": "scene"},
                }
                self._playing[name] = True
                self._places.pop(("source", name), None)
            elif item.amplitude != known.amplitude:
                step.setdefault("sources", {})[name] = {"amplitude": item.amplitude}
        for name, is_playing in self._playing.items():
            if is_playing != (name in now):
                self._playing[name] = name in now
                step.setdefault("sources", {}).setdefault(name, {})["playing"] = name in now
        self._sources |= now

    def _local(self, item):
        """The position of a source or listener in the frame of its object."""
        pose = self._poses[item.object]
        return pose[:3, :3].T @ (np.array(item.position) - pose[:3, 3])


def written(title, exchange):
    """The text of a conformance file."""
    lines = ",\n  ".join(json.dumps(one) for one in exchange)
    return (
        f'{{"title": {json.dumps(title)},\n "tolerances": {json.dumps(TOLERANCES)},\n'
        f' "exchange": [\n  {lines}\n ]}}\n'
    )


def main(name, first, last):

    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    haptic_tracing.register()
    with suspended():
        scene = build_sample(name)
    text = written(f"{SAMPLES[name].title}, as Blender plays it", recording(scene, first, last))
    path = Path(__file__).parent / f"sample_{name}.json.gz"
    path.write_bytes(gzip.compress(text.encode(), mtime=0))


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]), int(sys.argv[3]))
