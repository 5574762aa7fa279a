"""Sentences with names and numbers in them, as the core says them: translated by their templates."""

from __future__ import annotations

import re
from functools import cache

from bpy.app.translations import pgettext_iface as iface_

TEMPLATES = (
    # Why a listener feels nothing
    "there is no source, and no collision was strong enough to make one",
    "the gain of '{}' is 0",
    "only this one frame was traced: play to feel what arrives",
    "'{}' reaches it with {}, but is silent at this moment",
    "'{}' reaches it with {}, which at {} Hz is {} dB under the threshold of feeling",
    "'{}' is muted",
    "'{}' has amplitude 0",
    "the signal of '{}' was over at {} s",
    "in mode SD only '{}', the listener nearest to '{}', feels it",
    "with Localise at 1 only '{}', the listener nearest to '{}', feels it",
    "no connection at all is allowed: Max Connections is too low",
    "'{}' is {} away: {} is under the threshold of {}",
    "the way {} has {} connections, {} are allowed",
    "the best way, {}, passes on {}, under the threshold of {}: '{}' takes the most, {} dB over {}",
    "the contact of '{}' and '{}' passes on nothing",
    "'{}' passes on nothing, because its kappa is 1",
    "'{}' passes on nothing, because its rho is 0",
    "'{}' passes on nothing over {}: see its function, {}",
    "the way {} crosses an object twice in a row",
    "no contact leads from '{}' on '{}' to '{}', on which '{}' is",
    "no contact leads from '{}' to it: '{}' and '{}' are {} apart",
    "no contact leads from '{}' to it: '{}' and '{}' are {} apart, they touch from {} on",
    "no contact leads from '{}' to it: '{}' and '{}' are {} apart, and so are {} more pair on the way",
    "no contact leads from '{}' to it: '{}' and '{}' are {} apart, and so are {} more pairs on the way",
    "{} is muted: no actuator is chosen for it",
    # Warnings of a frame
    "{}: its transform is not finite; it takes no part",
    "some gains are above 1: paths were searched by their number of connections; energies count them as 1",
    "the budget was spent before it was certain that the best paths are the best: see the error bounds",
    "a sum over paths grows without bound: its gain is a lower bound; energy_balance suits such a scene",
    "the budget was spent before a sum over paths was certain: its gain is a lower bound, see the error bounds",
    "a gain is too large for a number: it is given as 1e300, a lower bound",
    "it is a {} and has no surface; use a mesh, or a listener or source on an empty",
)


def translated(sentence: str) -> str:
    """A sentence in the language of the interface; as it is where it is none of those that are known."""
    known = matched(sentence)
    if known is None:
        return iface_(sentence)
    template, values = known
    return iface_(template).format(*values)


def matched(sentence: str) -> tuple[str, tuple[str, ...]] | None:
    """The template of a sentence, and what is filled into its gaps; of several templates the one that leaves the least to gaps."""
    found = [(template, match.groups()) for template, pattern in _patterns() if (match := pattern.fullmatch(sentence))]
    return max(found, key=lambda item: len(item[0]), default=None)


@cache
def _patterns() -> tuple[tuple[str, re.Pattern[str]], ...]:
    return tuple((template, re.compile(re.escape(template).replace(r"\{\}", "(.+?)"), re.DOTALL)) for template in TEMPLATES)
