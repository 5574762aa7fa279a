"""Properties of a scene: how it is traced and shown, and its meters."""

from __future__ import annotations

from bpy.props import PointerProperty
from bpy.types import Context, PropertyGroup

from ...core.scene.rules import ContactSettings
from ...core.scene.values import Settings
from ..changes.events import mode_changed
from . import bake, live_output, materials, rules
from .callbacks import scene_changed, updating, view_changed
from .declared import holding
from .kinds import choice, switch, text

_COLUMNS = ("Listener", "Source", "Gain", "Level", "Margin")


@updating(view_changed)
class HapticMetersProperties(PropertyGroup):
    """The meters of a scene."""

    reasons = {
        "*": "view",
    }

    show: switch(
        "In Viewport",
        "Show over the 3D viewport how much each listener feels, otherwise in the sidebar",
        True,
    )
    show_body: switch("Body", "Draw a body whose parts light up where they feel something", True)
    corner: choice(
        "Corner",
        "Corner of the viewport in which the meters are drawn; the legend stands on the other side",
        (
            ("BOTTOM_LEFT", "Bottom Left", ""),
            ("BOTTOM_RIGHT", "Bottom Right", ""),
            ("TOP_LEFT", "Top Left", ""),
            ("TOP_RIGHT", "Top Right", ""),
        ),
        default="BOTTOM_LEFT",
    )
    sort_path: switch(
        "Sort by Loss",
        "Sort the objects of a path by loss, largest first, instead of in path order",
        update=None,
    )
    sort_table: choice(
        "Sort By",
        "The column by which the result is sorted: names in their order, numbers from the highest "
        "on",
        tuple((title.lower(), title, "") for title in _COLUMNS),
    )


def _mode_changed(self: HapticSceneProperties, context: Context) -> None:
    scene_changed(self, context)
    if not self.tracing:  # else the edit is traced
        mode_changed(self.id_data)


@updating(scene_changed)
@holding(
    ContactSettings,
    tolerance="contact_tolerance",
    energy="impact_energy",
    least_energy="minimum_energy",
    full_energy="maximum_energy",
)
@holding(Settings, more={"mode": {"update": _mode_changed}})
class HapticSceneProperties(PropertyGroup):
    """How a scene is traced and shown."""

    reasons = {
        "show_*": "view",
        "xray": "view",
        "tracing": "view",
        "impacts": "mute",
        "mode": "the study's four ways to render one scene",
        "strategy": "to compare with the paper",
        "contact_tolerance": "models with gaps: up to which gap objects touch",
    }

    tracing: switch(
        "Trace", "Trace haptics at every frame while the timeline plays or objects move", True
    )
    impact_table: PointerProperty(type=rules.HapticImpactTable)
    transmission_table: PointerProperty(type=rules.HapticTransmissionTable)
    textures: PointerProperty(type=rules.HapticTextureTable)
    show_overlay: switch(
        "Overlay", "Draw the haptic graph over the 3D viewport", True, update=view_changed
    )
    show_intra: switch(
        "Connections",
        "Draw the connections inside objects that carry signal",
        True,
        update=view_changed,
    )
    show_best_paths: switch(
        "Best Paths",
        "Mark the best path from each source to each listener",
        True,
        update=view_changed,
    )
    show_labels: switch(
        "All Labels",
        "Write names beside all sources and listeners, otherwise beside the watched listener",
        update=view_changed,
    )
    show_flow: switch(
        "Signal Flow",
        "Pulses run along the best paths while the timeline plays; not their real speed, which "
        "the eye could not follow",
        update=view_changed,
    )
    xray: switch(
        "In Front",
        "Draw the graph over objects instead of being hidden by them",
        True,
        update=view_changed,
    )
    bake: PointerProperty(type=bake.HapticBakeProperties)
    meters: PointerProperty(type=HapticMetersProperties)
    live_output: PointerProperty(type=live_output.HapticLiveOutputProperties)
    materials: PointerProperty(type=materials.HapticMaterialLibrary)
    kept_impacts: text(
        "Kept Impacts", "The impacts of the frame in which the file was saved", options={"HIDDEN"}
    )
