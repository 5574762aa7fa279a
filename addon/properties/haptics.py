"""What a designer authors, as properties of objects and scenes. Parameters live here; results live in `session`."""

from __future__ import annotations

from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, PointerProperty, StringProperty
from bpy.types import Context, Object, PropertyGroup

from ...core.scene.body import BODY_PARTS
from ...core.scene.functions import FUNCTIONS
from ..changes.redraw import redraw_viewports
from ..changes.revisions import mark_changed
from . import bake, live_output, materials, meters, modalities
from . import gltf as formats
from .function import FUNCTION_TITLES, FunctionParameters

FUNCTION_ITEMS = tuple((name, *FUNCTION_TITLES[name]) for name in FUNCTIONS)
SIGNAL_ITEMS = (
    ("SINE", "Sine", "A pure vibration"),
    ("PULSE", "Pulse Train", "Regular blows, like those of a jackhammer"),
    ("NOISE", "Noise", "A rough, random vibration"),
    ("FILE", "WAV File", "A recorded signal"),
    ("KEPT", "Imported", "The signal of an imported file, kept in this one"),
)
MIXING_ITEMS = (
    ("cumulative", "Cumulative", "Adds all signals up and holds the sum at the ceiling"),
    ("weighted", "Weighted", "Averages the signals by the priorities of their sources"),
    ("strongest", "Strongest", "Only the strongest signal is felt"),
    ("power", "Power", "Adds up energies: the root of the sum of squares"),
    ("custom", "Custom", "Your own formula of what the other methods give"),
)
MODE_ITEMS = (
    ("HT", "Haptic Tracing", "Through touching objects, as their properties say"),
    ("SD", "Single Nearest", "Only the listener nearest to each source, fading with distance alone"),
    ("MD", "All by Distance", "Every source directly to every listener, fading with distance alone"),
    ("MN", "All Alike", "Every source directly to every listener, without fading"),
)
BODY_PART_ITEMS = (
    ("NONE", "None", "Not a part of the body"),
    *((part.name, part.name.replace("_", " ").title(), f"Stands for the {part.name.replace('_', ' ')}") for part in BODY_PARTS),
)


def _changed(self: PropertyGroup, context: Context) -> None:
    mark_changed()


def _radius_changed(self: PropertyGroup, context: Context) -> None:
    """An empty that is drawn as a sphere shows the listener's extent."""
    empty = self.id_data
    if empty.type == "EMPTY" and empty.empty_display_type == "SPHERE":
        empty.empty_display_size = self.radius
    mark_changed()


def _view_changed(self: PropertyGroup, context: Context) -> None:
    redraw_viewports()


class HapticFunction(FunctionParameters):
    """Mixin: a modulation function of vibration and its parameters."""

    function: EnumProperty(
        name="Function",
        description="How the signal fades on its way through",
        items=FUNCTION_ITEMS,
        default="haptic_tracing",
        update=_changed,
    )


class HapticSourceProperties(PropertyGroup):
    """A haptic source: emits a signal."""

    enabled: BoolProperty(name="Haptic Source", description="This object emits a haptic signal", default=False, update=_changed)
    muted: BoolProperty(name="Mute", description="Keep the source but silence it", default=False, update=_changed)
    amplitude: FloatProperty(
        name="Amplitude",
        description="Strength of the emitted signal; can be animated",
        default=1.0,
        min=0.0,
        max=1.0,
        subtype="FACTOR",
        update=_changed,
    )
    signal: EnumProperty(name="Signal", description="What the source emits", items=SIGNAL_ITEMS, default="SINE", update=_changed)
    frequency: FloatProperty(
        name="Frequency",
        description="Vibrations or blows per second, in hertz; the skin feels 20 to 1000 Hz, best around 250 Hz",
        default=60.0,
        min=0.1,
        max=1000.0,
        soft_min=10.0,
        soft_max=500.0,
        update=_changed,
    )
    filepath: StringProperty(name="WAV File", description="The recorded signal, looped", subtype="FILE_PATH", update=_changed)
    decay: FloatProperty(
        name="Decay Time (s)",
        description="The source wears off from the first frame on: after so many seconds it is 37% as strong; 0 keeps it up",
        default=0.0,
        min=0.0,
        max=1e6,
        soft_max=60.0,
        update=_changed,
    )
    priority: FloatProperty(
        name="Priority",
        description="Weight of this source where a listener mixes by priority",
        default=1.0,
        min=0.0,
        soft_max=10.0,
        update=_changed,
    )
    imported: StringProperty(
        name="Imported", description="What an imported file says beyond these properties", options={"HIDDEN"}, update=_changed
    )


class HapticListenerProperties(PropertyGroup):
    """A haptic listener: receives signals at a place of the body."""

    enabled: BoolProperty(
        name="Haptic Listener", description="Signals are received at this object's origin", default=False, update=_changed
    )
    body_part: EnumProperty(
        name="Body Part",
        description="The place on the body that this listener stands for",
        items=BODY_PART_ITEMS,
        default="NONE",
        update=_changed,
    )
    radius: FloatProperty(
        name="Radius",
        description="Extent of the listener's bounding volume",
        default=0.05,
        min=0.0,
        soft_max=0.5,
        unit="LENGTH",
        update=_radius_changed,
    )
    gain: FloatProperty(
        name="Gain",
        description="Makes this listener feel more or less; can be animated",
        default=1.0,
        min=0.0,
        max=10.0,
        soft_max=2.0,
        update=_changed,
    )
    mixing: EnumProperty(name="Mixing", description="How signals that arrive together are combined", items=MIXING_ITEMS, update=_changed)
    mixing_expression: StringProperty(
        name="Formula",
        description="The mix, sample by sample, of sum, weighted, strongest and power (what the other methods give) and s_max (the "
        "ceiling)",
        default="s_max * tanh(sum / s_max)",
        maxlen=500,
        update=_changed,
    )
    s_max: FloatProperty(
        name="Ceiling",
        description="No sample of the mixed signal is stronger than this",
        default=1.0,
        min=0.01,
        max=1.0,
        subtype="FACTOR",
        update=_changed,
    )
    limiter: BoolProperty(
        name="Limiter",
        description="Turns a mix that would exceed the ceiling down, ahead of its peaks, instead of cutting it off, which distorts. "
        "All listeners then feel 5 ms later",
        default=False,
        update=_changed,
    )
    imported: StringProperty(
        name="Imported", description="What an imported file says beyond these properties", options={"HIDDEN"}, update=_changed
    )


class HapticObjectProperties(PropertyGroup, HapticFunction):
    """A haptic object: passes signals on."""

    enabled: BoolProperty(name="Haptic Object", description="Vibration passes through this object", default=False, update=_changed)
    kappa: FloatProperty(
        name="Kappa (κ)",
        description="The paper's transmissibility. As its function is published, only (1 - κ) ρ counts: a higher κ passes on less, "
        "but over a longer distance; 1 passes on nothing",
        default=0.1,
        min=0.0,
        max=1.0,
        subtype="FACTOR",
        precision=3,
        update=_changed,
    )
    rho: FloatProperty(
        name="Rho (ρ)",
        description="The paper's density coefficient. A higher ρ passes on more but fades faster with distance; 0 passes on nothing",
        default=0.9,
        min=0.0,
        max=1.0,
        subtype="FACTOR",
        precision=3,
        update=_changed,
    )
    wave_speed: FloatProperty(
        name="Wave Speed",
        description="Speed of vibration in this material; 0 passes signals on without delay",
        default=0.0,
        min=0.0,
        soft_max=5000.0,
        unit="VELOCITY",
        update=_changed,
    )
    medium: BoolProperty(
        name="Medium",
        description="A volume such as air or water: it touches everything that it overlaps",
        default=False,
        translation_context="Haptics",
        update=_changed,
    )
    imported: StringProperty(
        name="Imported", description="What an imported file says beyond these properties", options={"HIDDEN"}, update=_changed
    )
    source: PointerProperty(type=HapticSourceProperties)
    listener: PointerProperty(type=HapticListenerProperties)
    material: PointerProperty(type=materials.HapticObjectMaterial)
    modalities: PointerProperty(type=modalities.HapticObjectModalities)
    body: PointerProperty(
        type=Object, name="Body", description="The haptic object through which the listeners on this armature feel", update=_changed
    )
    felt: PointerProperty(type=bake.HapticFeltProperties)
    live_output: PointerProperty(type=live_output.HapticActuatorProperties)


class HapticSceneProperties(PropertyGroup):
    """How a scene is traced and shown."""

    tracing: BoolProperty(
        name="Trace", description="Trace haptics at every frame while the timeline plays or objects move", default=True, update=_changed
    )
    mode: EnumProperty(
        name="Mode",
        description="The rendering",
        items=MODE_ITEMS,
        update=_changed,
    )
    localise: FloatProperty(
        name="Localise",
        description="Blends from what touching objects carry everywhere (0) to only the listener nearest to each source (1). "
        "Part of the people in the paper's study liked to feel a source in one place",
        default=0.0,
        min=0.0,
        max=1.0,
        subtype="FACTOR",
        update=_changed,
    )
    strategy: EnumProperty(
        name="Strategy",
        description="How the gain from a source to a listener is computed",
        update=_changed,
        items=(
            ("auto", "Automatic", "All paths for persistent sources, the best path for impacts"),
            ("best_path", "Best Path", "Only the path that passes on most"),
            ("all_paths", "All Paths", "The sum of everything that arrives"),
            ("energy_balance", "Energy Balance", "Steady state of the energy that flows through all contacts; for dense piles"),
        ),
    )
    max_connections: IntProperty(
        name="Max Connections",
        description="Longest path, in connections through and between objects; 0 sets no limit",
        default=32,
        min=0,
        soft_max=128,
        update=_changed,
    )
    threshold: FloatProperty(
        name="Threshold",
        description="A path ends where its gain falls below this part of the source; 0 sets no limit",
        default=0.001,
        min=0.0,
        max=1.0,
        soft_max=0.1,
        precision=4,
        update=_changed,
    )
    epsilon: FloatProperty(
        name="Epsilon (ε)",
        description="Least attenuation per metre of the haptic tracing function",
        default=0.1,
        min=0.0,
        soft_max=1.0,
        precision=3,
        update=_changed,
    )
    contact_tolerance: FloatProperty(
        name="Contact Tolerance",
        description="Objects closer than this touch",
        default=0.01,
        min=0.0,
        soft_max=0.1,
        unit="LENGTH",
        precision=4,
        update=_changed,
    )
    patch_points: BoolProperty(
        name="Contact Points",
        description="Signals pass at each corner of where two objects lie on each other, instead of in its middle; the sum stays the same",
        default=False,
        update=_changed,
    )
    impacts: BoolProperty(
        name="Impacts", description="Collisions make temporary sources that play the impact signal once", default=True, update=_changed
    )
    impact_signal: EnumProperty(
        name="Signal",
        description="What impacts feel like",
        update=_changed,
        items=(
            ("MATERIALS", "By Material", "As the materials that meet: metal on stone rings, wood on soil thuds; plain where unknown"),
            ("PLAIN", "Plain", "A short knock of 150 Hz, whatever meets"),
        ),
    )
    minimum_energy: FloatProperty(
        name="Minimum Energy (J)",
        description="Collisions weaker than this, in joules, make no source; 5 J is a light contact",
        default=5.0,
        min=0.0,
        soft_max=100.0,
        update=_changed,
    )
    maximum_energy: FloatProperty(
        name="Full Energy (J)",
        description="A collision of this energy, in joules, plays the impact signal at full strength",
        default=100.0,
        min=0.001,
        soft_max=1000.0,
        update=_changed,
    )
    impact_energy: EnumProperty(
        name="Energy",
        description="The energy that a collision is judged by",
        update=_changed,
        items=(
            ("kinetic", "Of Both Motions", "What both objects bring along, moving as they do over the ground"),
            ("normal", "Of the Blow", "What comes together at the contact: the same however fast both travel side by side"),
        ),
    )
    refractory_time: FloatProperty(
        name="Refractory Time (s)",
        description="After an impact the same two objects make no other for so many seconds, however they bounce",
        default=0.1,
        min=0.0,
        soft_max=2.0,
        precision=3,
        update=_changed,
    )
    show_overlay: BoolProperty(name="Overlay", description="Draw the haptic graph over the 3D viewport", default=True, update=_view_changed)
    show_intra: BoolProperty(
        name="Connections", description="Draw the connections inside objects that carry signal", default=True, update=_view_changed
    )
    show_best_paths: BoolProperty(
        name="Best Paths", description="Mark the best path from each source to each listener", default=True, update=_view_changed
    )
    show_labels: BoolProperty(
        name="Labels", description="Write names and gains beside sources and listeners", default=True, update=_view_changed
    )
    show_flow: BoolProperty(
        name="Signal Flow",
        description="Pulses run along the best paths while the timeline plays; not their real speed, which the eye could not follow",
        default=False,
        update=_view_changed,
    )
    xray: BoolProperty(
        name="In Front", description="Draw the graph over objects instead of being hidden by them", default=True, update=_view_changed
    )
    bake: PointerProperty(type=bake.HapticBakeProperties)
    meters: PointerProperty(type=meters.HapticMetersProperties)
    live_output: PointerProperty(type=live_output.HapticLiveOutputProperties)
    materials: PointerProperty(type=materials.HapticMaterialLibrary)
    gltf: PointerProperty(type=formats.HapticGltfProperties)
    modalities: PointerProperty(type=modalities.HapticSceneModalities)
    imported: StringProperty(
        name="Imported", description="What an imported file says beyond these properties", options={"HIDDEN"}, update=_changed
    )
    imported_contacts: StringProperty(
        name="Imported Contacts",
        description="The contacts of an imported file, which count while objects stand where it put them",
        options={"HIDDEN"},
        update=_changed,
    )


CLASSES = (
    *bake.CLASSES,
    *formats.CLASSES,
    *meters.CLASSES,
    *live_output.CLASSES,
    *materials.CLASSES,
    *modalities.CLASSES,
    HapticSourceProperties,
    HapticListenerProperties,
    HapticObjectProperties,
    HapticSceneProperties,
)
