"""JSON5 as files of actuators use it: comments, keys without quotes, single quotes."""

from __future__ import annotations

import json
import re

# Each token is taken whole, and what is not closed reaches to the end: no text takes long.
_TOKEN = re.compile(
    r"(?P<comment>//[^\n]*+|/\*(?:.*?\*/|.*))"
    r'|"(?:\\.|[^"\\])*+"?'
    r"|'(?P<text>(?:\\.|[^'\\])*+)'?"
    r"|(?P<word>[A-Za-z_$][\w$]*+)(?P<colon>\s*+:)?"
    r"|[^\"'/A-Za-z_$]++|/",
    re.DOTALL,
)


def as_json(text: str) -> str:
    """The text as JSON; what else is wrong with it stays."""
    return _TOKEN.sub(_as_json, text)


def _as_json(found: re.Match[str]) -> str:
    if found["comment"]:
        return " "
    if found["text"] is not None:
        return json.dumps(found["text"].replace("\\'", "'"), ensure_ascii=False)
    return f"{json.dumps(found['word'])}:" if found["colon"] else found[0]
