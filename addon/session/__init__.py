"""Tracing sessions of scenes."""
