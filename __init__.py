"""Haptic Tracing: vibration propagated through touching objects.

Outside Blender this is the package ``haptic_tracing``; inside it is the extension ``bl_ext.<repository>.haptic_tracing``.
"""


def register() -> None:
    """Called by Blender when the extension is enabled."""
    from . import addon

    addon.register()


def unregister() -> None:
    """Called by Blender when the extension is disabled."""
    from . import addon

    addon.unregister()
