"""Operators that tag and add objects, trace, bake, export, and select problems."""
