"""glTF: haptics in the files of Blender's exporter, and the export for an engine."""

EXPORTS = (("gltf", f"{__name__}.export"),)
