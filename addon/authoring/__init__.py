"""Edits shared by several operators: materials, body listeners, signals."""
