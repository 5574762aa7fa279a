"""Files: haptic scenes and tracks out of Blender, haptic scenes and signals into it, and haptics in glTF."""

from __future__ import annotations


def register() -> None:
    """Offer the operators, their menu entries, and the kinds of files that can be dropped."""
    from . import menus

    menus.register()


def unregister() -> None:
    """The reverse of `register`; work that is still going on is given up."""
    from . import job, menus

    job.stop()
    menus.unregister()
