"""Temporary sources: what begins to sound when bodies strike, rub or pass each other."""
