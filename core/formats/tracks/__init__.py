"""Tracks: the signals of listeners in the formats of players and SDKs."""
