"""Classification of the sources of a listener: felt, masked by others, or too weak."""

from __future__ import annotations

from collections import Counter
from typing import Literal

import numpy as np

from ..arrays import FloatArray
from ..frozen import frozen
from ..perception import masked_by
from ..scene.values import Source
from .frame_result import FrameResult, Sounding
from .groups import MAX_GAIN
from .mixdown import source_voices, steady
from .renderer import SAMPLE_RATE, ListenerMix, Renderer

SECONDS = 0.25
"""Duration over which sources are compared."""


@frozen
class FeltSource:
    """``margin``: sensation level of the source alone [dB]. ``masker``: the source
    that masks it, "" for none."""

    source: Source
    margin: float
    masker: str

    @property
    def state(self) -> Literal["felt", "masked", "weak"]:
        """Weak if it would not be felt alone, hidden if it is masked."""
        return "weak" if self.margin <= 0 else "masked" if self.masker else "felt"


@frozen
class FeltSources:
    """The sources that reach a listener: felt, masked and weak ones, the strongest of each
    first."""

    listener: str
    sources: tuple[FeltSource, ...]

    def counts(self) -> tuple[int, int, int]:
        """Numbers of felt, masked and weak sources."""
        found = Counter(item.state for item in self.sources)
        return found["felt"], found["masked"], found["weak"]


def shown_sounding(result: FrameResult) -> Sounding:
    """The active sources of a frame, from the beginning of its interval."""
    return Sounding(
        result.first_sample / result.sample_rate,
        result.sources,
        result.listeners,
        result.propagation,
    )


def felt_sources(
    sounding: Sounding, listener: int, sample_rate: float = SAMPLE_RATE
) -> FeltSources:
    """Classify the sources of listener number ``listener`` as if they lasted for `SECONDS`."""
    margins, maskers = masked_by(
        source_samples(sounding, listener, SECONDS, sample_rate),
        sample_rate,
        sounding.listeners[listener].device,
    )
    names = [source.name for source in sounding.sources]
    found = [
        FeltSource(source, margin, names[masker] if masker >= 0 else "")
        for source, margin, masker in zip(
            sounding.sources, margins.tolist(), maskers.tolist(), strict=True
        )
        if margin > -np.inf
    ]
    found.sort(
        key=lambda item: (
            ("felt", "masked", "weak").index(item.state),
            -item.margin,
            item.source.name,
        )
    )
    return FeltSources(sounding.listeners[listener].name, tuple(found))


def source_samples(
    sounding: Sounding, listener: int, seconds: float, sample_rate: float
) -> FloatArray:
    """Samples (s, n) of each source at a listener, before mixing."""
    voices = source_voices(sounding)
    apart = [
        voice._replace(
            gains=np.multiply.outer(one, voice.gains[listener]),
            delays=None if voice.delays is None else np.full(len(voices), voice.delays[listener]),
        )
        for voice, one in zip(voices, np.eye(len(voices)), strict=True)
    ]
    renderer = Renderer(
        [ListenerMix(source.name, s_max=MAX_GAIN) for source in sounding.sources], sample_rate
    )
    return steady(renderer, sounding.time, seconds, apart)
