"""Tracks: what listeners feel, in the formats of players and SDKs."""
