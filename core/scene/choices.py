"""Enumerations of an author's choices."""

from __future__ import annotations

import enum


class Mode(enum.StrEnum):
    """The four rendering modes of the paper's study."""

    HT = "HT"  # haptic graph, the objects' own functions
    SD = "SD"  # haptic graph, only the listener nearest to the source, distance alone
    MD = "MD"  # every source directly to every listener, distance alone
    MN = "MN"  # every source directly to every listener, no attenuation


class Strategy(enum.StrEnum):
    """How the gain from a source to a listener is computed."""

    BEST_PATH = "best_path"
    AS_IN_THE_PAPER = (
        "as_in_the_paper"  # all paths for persistent sources, the best path for temporary ones
    )


class SourceKind(enum.StrEnum):
    PERSISTENT = "persistent"
    TEMPORARY = "temporary"
