"""Jobs, handlers, base classes of operators, texts, and differences between versions of Blender."""
