"""Edits that several operators share: materials, body listeners, signals."""
