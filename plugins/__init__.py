"""Plug-ins, one folder each, as `docs/plugins.md` describes."""
