"""Operators: tag objects, add things, trace, bake, export, look at problems."""
