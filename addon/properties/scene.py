"""Properties of a scene: how it is traced and shown, its meters, and its haptics in glTF files."""

from __future__ import annotations

from bpy.props import IntProperty, PointerProperty
from bpy.types import PropertyGroup

from . import bake, live_output, materials, modalities, rules
from .callbacks import Imported, changed, updating, view_changed
from .kinds import choice, limited, number, share, switch, text

MODE_ITEMS = (
    ("HT", "Haptic Tracing", "Through touching objects, as their properties say"),
    ("SD", "Single Nearest", "Only the listener nearest to each source, fading with distance alone"),
    ("MD", "All by Distance", "Every source directly to every listener, fading with distance alone"),
    ("MN", "All Alike", "Every source directly to every listener, without fading"),
)


@updating(view_changed)
class HapticMetersProperties(PropertyGroup):
    """The meters of a scene."""

    show: switch("Meters", "Draw meters over the 3D viewport: how much each listener feels", True)
    show_scope: switch("Scope", "Draw the last second of the selected listener, or of the one that feels the most", True)
    show_body: switch("Body", "Draw a body whose parts light up where they feel something", True)
    show_lane: switch(
        "Timeline of Touch",
        "Draw over Timeline and Dope Sheet what each listener feels: waves and impacts of the frames baked or played, and in "
        "orange the threshold of feeling",
        True,
    )
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
    sort_path: switch("Sort by Loss", "Sort the objects of a path by loss, largest first, instead of in path order", update=None)


class HapticGltfProperties(PropertyGroup):
    """The data that is written when the scene is exported as glTF."""

    use_extras: switch("Haptics", "Roles, haptic properties, functions and contacts, in the extras of nodes", True)
    use_material: switch("MPEG Haptic Material", "Haptic materials of meshes as an extension of ISO/IEC 23090-14")
    material_name: text("Name", "Name of that extension, because drafts of the standard differ", "MPEG_haptic_material", maxlen=60)


@updating()
class HapticSceneProperties(Imported, PropertyGroup):
    """How a scene is traced and shown."""

    tracing: switch("Trace", "Trace haptics at every frame while the timeline plays or objects move", True)
    mode: choice("Mode", "The rendering", MODE_ITEMS)
    localise: share(
        "Localise",
        "Blends from propagation through touching objects (0) to the nearest listener of each source alone (1). "
        "Some participants of the paper's study preferred to feel a source in one place",
        0.0,
    )
    strategy: choice(
        "Strategy",
        "How the gain from a source to a listener is computed",
        (
            ("auto", "Automatic", "The best path for every source, over any number of connections", 0),
            ("as_in_the_paper", "As in the Paper", "All paths for persistent sources, the best path for impacts", 4),
            ("best_path", "Best Path", "Only the path that passes on most", 1),
            ("all_paths", "All Paths", "The sum of everything that arrives", 2),
            ("energy_balance", "Energy Balance", "Steady state of the energy that flows through all contacts; for dense piles", 3),
        ),
    )
    max_connections: IntProperty(
        name="Max Connections",
        description="Longest path, in connections through and between objects; 0 sets no limit",
        default=32,
        min=0,
        soft_max=128,
    )
    threshold: limited(
        "Threshold",
        "A path ends where its gain falls below this part of the source; 0 sets no limit",
        0.001,
        (0.0, 1.0),
        soft_max=0.1,
        precision=4,
    )
    epsilon: number(
        "Epsilon (ε, 1/m)",
        "Least attenuation per metre, also of materials that would transmit without loss. The paper's ε",
        0.1,
        (0.0, 1.0),
        precision=3,
    )
    contact_tolerance: number("Contact Tolerance", "Objects closer than this touch", 0.01, (0.0, 0.1), unit="LENGTH", precision=4)
    impacts: switch("Impacts", "Collisions make temporary sources that play the impact signal once", True)
    impact_signal: choice("Signal", "What impacts feel like", rules.SIGNAL_ITEMS)
    minimum_energy: rules.least_energy()
    maximum_energy: rules.full_energy()
    impact_energy: choice(
        "Energy",
        "The energy that a collision is judged by",
        (
            ("kinetic", "Of Both Motions", "Kinetic energy of both objects: ½ m₁ v₁² + ½ m₂ v₂²"),
            ("normal", "Of the Blow", "Energy of the relative motion along the contact normal: ½ μ v² with the reduced mass μ"),
        ),
    )
    refractory_time: rules.refractory()
    impact_table: PointerProperty(type=rules.HapticImpactTable)
    transmission_table: PointerProperty(type=rules.HapticTransmissionTable)
    textures: PointerProperty(type=rules.HapticTextureTable)
    show_overlay: switch("Overlay", "Draw the haptic graph over the 3D viewport", True, update=view_changed)
    show_intra: switch("Connections", "Draw the connections inside objects that carry signal", True, update=view_changed)
    show_best_paths: switch("Best Paths", "Mark the best path from each source to each listener", True, update=view_changed)
    show_labels: switch("Labels", "Write names and amplitudes beside sources and listeners", True, update=view_changed)
    show_flow: switch(
        "Signal Flow",
        "Pulses run along the best paths while the timeline plays; not their real speed, which the eye could not follow",
        update=view_changed,
    )
    xray: switch("In Front", "Draw the graph over objects instead of being hidden by them", True, update=view_changed)
    bake: PointerProperty(type=bake.HapticBakeProperties)
    meters: PointerProperty(type=HapticMetersProperties)
    live_output: PointerProperty(type=live_output.HapticLiveOutputProperties)
    materials: PointerProperty(type=materials.HapticMaterialLibrary)
    gltf: PointerProperty(type=HapticGltfProperties)
    modalities: PointerProperty(type=modalities.HapticSceneModalities)
    imported_contacts: text(
        "Imported Contacts",
        "The contacts of an imported file, which count while objects stand where it put them",
        options={"HIDDEN"},
        update=changed,
    )
    kept_impacts: text("Kept Impacts", "The impacts of the frame in which the file was saved", options={"HIDDEN"})
