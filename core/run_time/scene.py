"""A haptic scene and what propagates in it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from copy import copy
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

from ..contacts.contact_set import ContactSet
from ..contacts.scene_contacts import contacts_of_scene
from ..formats.export import Export
from ..formats.haptic_scene import export_of
from ..formats.io.error import FormatError, json_pointer
from ..formats.io.strict_json import parse_json, read_json
from ..formats.scene.recording import Recording, traced
from ..formats.scene.scene_json import (
    FORMAT,
    VERSION,
    scene_to_dict,
    valid_document,
    write_document,
)
from ..graph.haptic_graph import HapticGraph, NoGain, graph_of_scene
from ..propagation import Propagation, propagate
from ..render.arrival import signal_gains
from ..render.frame_result import FrameResult
from ..render.renderer import SAMPLE_RATE
from ..scene.references import require_known
from ..scene.values import Contact, HapticScene
from .given import plain
from .result import Result


def load(path: str | Path) -> Scene:
    """The scene in a ``.json`` or ``.json.gz`` file. Raises FormatError, which names the place in
    the file, or OSError.

    >>> Scene(objects=[{"name": "bench", "kappa": 0.1, "rho": 0.8}]).save("bench.json")
    >>> load("bench.json").content.objects[0].name
    'bench'
    """
    return Scene.of_document(read_json(path), path)


def loads(text: str | bytes) -> Scene:
    """The scene in the text of a scene file. Raises FormatError.

    >>> loads('{"format": "haptic-scene", "version": "1.1", "objects": [{"name": "bench"}]}')
    Traceback (most recent call last):
    haptic_tracing.core.formats.io.error.FormatError: scene: /objects/0/kappa: is required
    """
    return Scene.of_document(
        parse_json(text.encode() if isinstance(text, str) else text, "scene"), "scene"
    )


class Scene:
    """A haptic scene: objects, contacts, sources, listeners and settings.

    ``content`` has its values, ``export`` all that its file holds, ``file`` names it in errors.
    Args of the constructor: the lists and settings of a scene file, as dictionaries; NumPy's arrays
    and numbers may stand in them. The examples of the methods go on with this ``scene``:

    >>> scene = Scene(
    ...     objects=[{"name": "bench", "kappa": 0.1, "rho": 0.8,
    ...               "propagation": {"function": "linear", "range": 4}}],
    ...     sources=[{"name": "drill", "object": "bench", "position": [0, 0, 0]}],
    ...     listeners=[{"name": "hand", "object": "bench", "position": [1, 0, 0],
    ...                 "radius": 0}],
    ... )
    """

    def __init__(self, **parts: Any) -> None:
        self._read({"format": FORMAT, "version": VERSION, "objects": [], **plain(parts)}, "scene")

    @classmethod
    def of_document(cls, document: Any, file: str | Path) -> Scene:
        """The scene of a parsed file. Raises FormatError."""
        scene = cls.__new__(cls)
        scene._read(document, file)
        return scene

    def _read(self, document: Any, file: str | Path) -> None:
        self.document = valid_document(document, file)
        self.export = export_of(self.document, Path(file))
        self.content = self.export.need_scene()
        self.file = file

    @classmethod
    def of_values(cls, content: HapticScene) -> Scene:
        """A scene made of the core's values instead of read from a file."""
        return cls.of_document(scene_to_dict(content), "scene")

    def __repr__(self) -> str:
        lists = ("objects", "contacts", "sources", "listeners")
        counts = ", ".join(f"{len(getattr(self.content, name))} {name}" for name in lists)
        return f"<Scene of {counts}>"

    content: HapticScene
    export: Export
    document: Mapping[str, Any]
    file: str | Path

    def with_settings(self, **chosen: Any) -> Scene:
        """A copy of this scene with other settings of propagation, by their names in the file.
        Raises ValueError.

        >>> scene.with_settings(mode="MN").gains()  # without attenuation
        {('drill', 'hand'): 1.0}
        """
        scene = copy(self)
        with self._errors():
            known = asdict(self.content.settings)
            for name in chosen:
                require_known(name, known, "setting", ("settings", name))
            scene.content = replace(self.content, settings=replace(self.content.settings, **chosen))
        return scene

    def contacts(self) -> tuple[Contact, ...]:
        """The contacts that the scene lists, otherwise those found from shapes and poses. Raises
        ValueError.

        >>> ball = {"kappa": 0.1, "rho": 0.8, "shape": {"type": "sphere", "radius": 1}}
        >>> balls = Scene(objects=[
        ...     {**ball, "name": "left"},
        ...     {**ball, "name": "right", "pose": {"position": [2, 0, 0]}},
        ... ])
        >>> [(contact.objects, contact.positions[0]) for contact in balls.contacts()]
        [(('left', 'right'), (1.0, 0.0, 0.0))]
        """
        names = [item.name for item in self.content.objects]
        return self.content.contacts or self.contacts_found().to_contacts(names)

    def contacts_found(self, tolerance: float | None = None) -> ContactSet:
        """The contacts between objects with shapes whose signed distance is at most ``tolerance``
        metres, by default that of the scene's rules. Raises ValueError.

        >>> len(scene.contacts_found(tolerance=0.1))
        0
        """
        with self._errors():
            return contacts_of_scene(self.content, tolerance)

    def with_contacts(self) -> HapticScene:
        """The content with its `contacts`. Raises ValueError.

        >>> scene.with_contacts().contacts
        ()
        """
        return replace(self.content, contacts=self.contacts())

    def graph(self) -> HapticGraph:
        """The haptic graph. Raises ValueError.

        >>> graph = scene.graph()  # nodes: the source and the listener
        >>> graph.node_count, graph.contact_count
        (2, 0)
        """
        with self._errors():
            return graph_of_scene(self.with_contacts())

    def propagate(self, graph: HapticGraph | None = None) -> Propagation:
        """Gains and paths of all pairs; ``graph``: that of the scene, if it is known.
        Raises ValueError.

        >>> found = scene.propagate()
        >>> found.gain.tolist(), found.paths.tolist()  # a row for each source
        ([[0.75]], [[1]])
        """
        graph = self.graph() if graph is None else graph
        with self._errors():
            return propagate(graph, self.content.settings)

    def result(self) -> Result:
        """What propagates, by names. Raises ValueError.

        >>> scene.result()["drill", "hand"].gain
        0.75
        """
        graph = self.graph()
        return Result(self.with_contacts(), graph, self.propagate(graph))

    def gains(self) -> dict[tuple[str, str], float]:
        """The gain of the paths from each source to each listener, by their names; amplitudes of
        sources and gains of listeners are not in it. Raises ValueError.

        >>> scene.gains()
        {('drill', 'hand'): 0.75}
        """
        gain = signal_gains(self.content.sources, self.propagate())
        return {
            (source.name, listener.name): float(gain[row, column])
            for row, source in enumerate(self.content.sources)
            for column, listener in enumerate(self.content.listeners)
        }

    def frames(
        self, seconds: float = 1.0, sample_rate: float = SAMPLE_RATE
    ) -> Iterator[FrameResult]:
        """Trace the recorded frames, with samples at ``sample_rate`` [Hz]; of a scene without any,
        frames of ``seconds`` [s] in which nothing moves. Raises ValueError.

        >>> *_, last = scene.frames(seconds=0.5)
        >>> last.time, last.gains.tolist()
        (0.5, [[0.75]])
        """
        recording = self.export.recording
        with self._errors():
            yield from (
                traced(self.with_contacts(), Recording.still(seconds), sample_rate)
                if recording is None
                else traced(self.content, recording, sample_rate)
            )

    def save(self, path: str | Path) -> None:
        """Write the scene as ``.json`` or ``.json.gz``. Raises OSError.

        >>> scene.save("bench.json.gz")
        >>> load("bench.json.gz").gains() == scene.gains()
        True
        """
        write_document({**self.document, "settings": scene_to_dict(self.content)["settings"]}, path)

    @contextmanager
    def _errors(self) -> Iterator[None]:
        """Name the file, and the place of a function that gives no valid gain."""
        try:
            yield
        except FormatError:
            raise
        except NoGain as error:
            raise FormatError(self.file, json_pointer(self._place_of(error)), str(error)) from None
        except ValueError as error:
            raise ValueError(f"{self.file}: {error}") from None

    def _place_of(self, error: NoGain) -> tuple[str | int, ...]:
        """Keys and indices of the function that gives no valid gain, () for one of a rule."""
        bodies = [{item.name} for item in self.content.objects]
        contacts = [set(contact.objects) for contact in self.content.contacts]
        for kind, known, key in (
            ("objects", bodies, "propagation"),
            ("contacts", contacts, "transmission"),
        ):
            if set(error.objects) in known:
                return kind, known.index(set(error.objects)), key
        return ()
