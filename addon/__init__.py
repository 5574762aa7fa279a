"""The Blender side: properties, panels, operators, handlers and overlays. Thin: what is computed is
computed in `core`."""
