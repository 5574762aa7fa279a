"""The answer to a step of a run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ..arrays import FloatArray
from ..contacts.impacts import Impact
from ..frozen import frozen
from ..message import sentence
from ..render.frame_result import FrameResult
from ..render.history import History, lasts, still_samples
from ..render.levels import LEVEL_SECONDS, finite, level_and_margin
from ..scene.values import HapticObject


@frozen
class Level:
    """What a listener feels: ``level``, the RMS of the last quarter second [dB of full scale], and
    ``margin`` above the threshold of feeling [dB], both None for silence; ``gains``: of the paths
    from each sounding source, by its name."""

    level: float | None
    margin: float | None
    gains: Mapping[str, float]


@frozen
class Blow:
    """An impact at ``time`` [s] between two objects, with its ``position`` [m], its ``energy`` [J],
    the ``amplitude`` of its signal that follows from the energy, and the ``gains`` of the paths to
    the listeners, by name. ``estimated``: something else than physics moves one of them, and poses
    do not tell how it moved between them."""

    time: float
    objects: tuple[str, str]
    position: tuple[float, float, float]
    energy: float
    amplitude: float
    estimated: bool
    gains: Mapping[str, float]


@frozen(repr=False)
class Step:
    """The answer to a step that ends at ``time`` [s].

    ``levels`` by listener; ``impacts`` since the last step; ``block`` (listeners, n): the samples
    since the last step, the first of them number ``first_sample``, a row for each of ``listeners``;
    ``milliseconds`` by stage; ``warnings``: sentences.
    """

    time: float
    levels: Mapping[str, Level]
    impacts: tuple[Blow, ...]
    block: FloatArray
    first_sample: int
    listeners: tuple[str, ...]
    milliseconds: Mapping[str, float]
    warnings: tuple[str, ...]

    def __repr__(self) -> str:
        levels = ", ".join(
            f"{name}: {'silent' if one.level is None else f'{one.level:.1f} dB'}"
            for name, one in self.levels.items()
        )
        return (
            f"<Step at {self.time:.6g} s: {levels or 'no listeners'}; {len(self.impacts)} impacts, "
            f"{self.block.shape[1]} samples>"
        )


def answer(
    result: FrameResult, history: History, objects: Sequence[HapticObject], time: float
) -> Step:
    """The answer of a traced frame, whose samples are the last of the ``history``; ``objects``:
    that its impacts number; ``time``: of its end by the caller's clock [s].

    Levels are those of the last quarter second; where there are fewer samples since the beginning,
    those of the frame as if it lasted.
    """
    known = result.block is not None and lasts(result, history.count)
    samples = history.all(LEVEL_SECONDS) if known else still_samples(result)
    window = round(LEVEL_SECONDS * result.sample_rate)
    level, margin = (
        values.tolist()
        for values in level_and_margin(samples[:, -window:], result.sample_rate, result.listeners)
    )
    sources, listeners = (
        [item.name for item in items] for items in (result.sources, result.listeners)
    )
    by_listener = result.gains.T.tolist()
    first = len(result.sources) - len(result.impacts)
    return Step(
        time=time,
        levels={
            name: Level(
                finite(level[k]),
                finite(margin[k]),
                dict(zip(sources, by_listener[k], strict=True)),
            )
            for k, name in enumerate(listeners)
        },
        impacts=tuple(
            _blow(result, impact, first + k, objects, time - result.time)
            for k, impact in enumerate(result.impacts)
        ),
        block=np.zeros((len(listeners), 0)) if result.block is None else result.block,
        first_sample=result.first_sample,
        listeners=tuple(listeners),
        milliseconds=result.milliseconds,
        warnings=tuple(sentence(warning) for warning in result.warnings),
    )


def _blow(
    result: FrameResult, impact: Impact, row: int, objects: Sequence[HapticObject], first: float
) -> Blow:
    """An impact.

    Args:
        result: of the frame.
        impact: one of its impacts.
        row: the number of its source.
        objects: that impacts number.
        first: time of the caller's clock from which times are counted [s].
    """
    one, other = impact.objects
    return Blow(
        time=first + impact.time,
        objects=(objects[one].name, objects[other].name),
        position=impact.positions[0],
        energy=impact.energy,
        amplitude=result.sources[row].amplitude,
        estimated=impact.estimated,
        gains=dict(
            zip((item.name for item in result.listeners), result.gains[row].tolist(), strict=True)
        ),
    )
