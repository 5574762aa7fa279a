"""JSON objects as Python values."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

Form = Mapping[str, Any]
"""An object that is read, or values by name."""
JsonObject = dict[str, Any]
"""An object that is made."""
