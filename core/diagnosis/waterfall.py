"""What is played to a listener, as a sum in decibels along the path from one of its sources."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from ..frozen import frozen
from ..graph.distance_only import distance_only
from ..render.frame_result import FrameResult, Sounding
from ..render.levels import vibration_rms
from ..render.masking import source_samples
from ..scene.choices import Mode
from ..scene.values import Source
from .losses import object_losses


@frozen
class Hop:
    """An object on a path, with its contact to the next one: loss [dB] and distance [m]."""

    object: str
    loss: float
    distance: float


@frozen
class Waterfall:
    """From the amplitude of a source to the level of a listener, all in decibels, minus infinity
    for silence.

    Attributes:
        amplitude: of the source.
        hops: the objects of the best path; () in the modes without paths.
        gain: of the path, or of all paths that the strategy counts together.
        listener_gain: the factor of the listener's mix.
        signal: RMS of what the source sends, relative to a constant of its amplitude: −3 dB for a
            sine.
        level: RMS of what is played, relative to full scale.
    """

    listener: str
    source: Source
    amplitude: float
    hops: tuple[Hop, ...]
    gain: float
    listener_gain: float
    signal: float
    level: float

    @property
    def others(self) -> float:
        """What the gain has beyond the best path: other paths, and the weights of frequency bands.
        The whole gain in the modes without paths."""
        return self.gain + sum(hop.loss for hop in self.hops)

    @property
    def mix(self) -> float:
        """What the level has beyond this source: other sources and how they are mixed, ceiling
        and limiter, and what has changed within the time over which the level is measured.
        0 where this source is silent."""
        alone = self.amplitude + self.gain + self.listener_gain + self.signal
        return self.level - alone if math.isfinite(alone) else 0.0


def waterfall(
    result: FrameResult, mode: Mode, row: int, column: int, level: float, seconds: float
) -> Waterfall:
    """The waterfall from a source, which reaches the listener, to a listener.

    Args:
        result: the traced frame.
        mode: the mode of the frame.
        row: number of the source.
        column: number of the listener.
        level: of the listener [dB of full scale].
        seconds: the time over which the level is measured.
    """
    source = result.sources[row]
    listener = result.listeners[column]
    propagation = result.propagation
    nodes = propagation.best_path.get((row, column), ())
    hops: tuple[Hop, ...] = ()
    if nodes and mode in (Mode.HT, Mode.SD):
        graph = distance_only(result.graph) if mode is Mode.SD else result.graph
        hops = tuple(
            Hop(*loss) for loss in object_losses(graph.in_band(graph.sources[row].band), nodes)
        )
    arriving = float(result.amplitudes[row, column])
    return Waterfall(
        listener=listener.name,
        source=source,
        amplitude=_decibels(source.amplitude),
        hops=hops,
        gain=_decibels(float(result.gains[row, column])),
        listener_gain=_decibels(listener.gain),
        signal=_decibels(_rms_alone(result, row, column, seconds) / arriving),
        level=level,
    )


def _rms_alone(result: FrameResult, row: int, column: int, seconds: float) -> float:
    """RMS of a source at a listener of gain 1, without other sources, from the beginning of the
    frame's interval."""
    propagation = result.propagation
    pair = np.ix_([row], [column])
    alone = replace(
        propagation,
        gain=propagation.gain[pair],
        band_gain=None if propagation.band_gain is None else propagation.band_gain[pair],
        delay=None if propagation.delay is None else propagation.delay[pair],
    )
    start = result.first_sample / result.sample_rate
    sounding = Sounding(
        start, (result.sources[row],), (replace(result.listeners[column], gain=1.0),), alone
    )
    samples = source_samples(sounding, 0, seconds, result.sample_rate)
    return float(vibration_rms(samples[0], result.sample_rate))


def _decibels(factor: float) -> float:
    return 20 * math.log10(factor) if factor > 0 else -math.inf
