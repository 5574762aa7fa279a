"""All computation, without Blender."""

__version__ = "0.1.0"
