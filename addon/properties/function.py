"""Properties of modulation functions: their kinds and their parameters."""

from __future__ import annotations

from bpy.props import EnumProperty

from .kinds import choice, limited, number, share, text

FUNCTIONS = {
    "identity": ("Identity", "Passes everything on unchanged"),
    "constant": ("Constant", "The same gain over any distance"),
    "linear": ("Linear", "1 - d / range: silent from the range on"),
    "exponential": ("Exponential", "e^(-α d): fades with distance alone"),
    "haptic_tracing": ("Haptic Tracing", "K e^(-max(K, ε) d) with K = (1 - κ) ρ: fades with distance as the two properties say"),
    "expression": ("Expression", "Your own formula of x, d, kappa, rho, epsilon"),
    "physical": ("Physical", "Spreading and damping of measured materials, by loss factor, wave speed and wave type"),
    "conduction": ("Conduction", "e^(-m d) with m = √(2 h / (k t)): fades as heat does that leaks into the air on its way"),
    "impedance": (
        "Impedance",
        "2 √(Z1 Z2) / (Z1 + Z2), Z density times speed, of two physical materials; else everything",
    ),
    "resilient": ("Resilient Layer", "Transmissibility of a mass on a spring: everything up to its resonance, less and less above it"),
    "normal_force": ("Pressing Force", "(F / reference)^exponent, at most 1, with the force that presses resting objects together"),
}
"""Title and description of each function of the core, by its name. Files store a choice as its index in this order."""

VIBRATION_FUNCTIONS = tuple(FUNCTIONS)[:7]
"""Functions of haptic objects."""
TRANSMISSIONS = ("impedance", "identity", "constant", "linear", "exponential", "expression", "resilient", "normal_force")
"""Functions of contacts."""

WAVE_ITEMS = (
    ("rod", "Rod", "Along a rod, a string or a small body: no spreading"),
    ("plate", "Plate", "Bending waves in a plate of a thickness, which spread over its surface"),
    ("surface", "Ground", "Waves along the surface of the ground"),
    ("solid", "Solid", "Through a volume, in all directions"),
    ("limb", "Limb", "Along a part of a body, which moves as a whole up to its resonance"),
)


class PhysicalParameters:
    """Mixin: the parameters of the physical function."""

    wave: choice("Wave", "How vibration travels in the body", WAVE_ITEMS, default="solid")
    loss_factor: number(
        "Loss Factor",
        "Part of the energy that a cycle turns into heat, over 2π: steel 0.0002, wood 0.01, rubber 0.15",
        0.01,
        (0.0, 1.0),
        precision=5,
    )
    phase_speed: number(
        "Speed (m/s)",
        "Speed of the waves in metres per second, for plates that of extensional waves: steel 5100, soil 200",
        1000.0,
        (0.1, 6000.0),
    )
    density: number(
        "Density (kg/m³)",
        "With the speed it gives the impedance that contacts may depend on: steel 7850, water 1000, foam 40",
        1000.0,
        (0.1, 20000.0),
    )
    plate_thickness: number("Thickness", "Thickness of the plate", 0.1, (1e-4, 1.0), unit="LENGTH", precision=4)
    absorption: number(
        "Joints (1/m)",
        "Attenuation per metre that edges and joints add at every frequency; walls and floors of a building 0.12 to 0.35",
        0.0,
        (0.0, 1.0),
        precision=3,
    )
    material_k: limited(
        "Material K", "(1 - κ) ρ at which the numbers above hold; a lower one damps more, a higher one less", 0.5, (0.01, 0.99), precision=3
    )
    reference_distance: number(
        "Source Radius", "Radius of the region that a source drives; spreading begins there", 0.5, (0.001, 10.0), unit="LENGTH"
    )
    extent: number(
        "Extent", "Distance over which vibration spreads in the body, its own length; 0: without end", 0.0, (0.0, 100.0), unit="LENGTH"
    )
    resonance: number(
        "Resonance (Hz)",
        "A limb moves as a whole up to this frequency: trunk 5, elbow 8, knee 25, wrist 30, fingertip 200",
        20.0,
        (0.0, 300.0),
    )


PARAMETERS = {
    "exponential": {"alpha": "alpha"},
    "linear": {"range": "range"},
    "constant": {"gain": "constant"},
    "expression": {"expression": "expression"},
    "physical": {"thickness" if name == "plate_thickness" else name: name for name in PhysicalParameters.__annotations__},
}
"""Parameters of the functions of objects: property by name in the core, by function."""

CONTACT_PARAMETERS = {
    **PARAMETERS,
    "resilient": {"stiffness": "stiffness", "load": "load", "loss_factor": "layer_loss", "fall_off": "fall_off"},
    "normal_force": {"reference": "reference", "exponent": "exponent"},
}
"""The same for the functions of contacts."""


def function_property(names: tuple[str, ...], default: str) -> EnumProperty:
    """The choice of one of the functions ``names``."""
    return choice("Function", "How the signal fades on its way through", tuple((name, *FUNCTIONS[name]) for name in names), default=default)


class FunctionParameters:
    """Mixin: the parameters of all functions of objects."""

    alpha: number("Alpha (1/m)", "Attenuation per metre; 0.2 is the paper's distance-only function", 0.2, (0.0, 5.0), precision=3)
    range: number("Range", "Distance from which on nothing is felt", 10.0, (0.001, 100.0), unit="LENGTH")
    constant: share("Gain", "The gain over any distance", 0.5)
    expression: text(
        "Expression",
        "Formula of x (the signal), d (metres), kappa, rho, epsilon. Functions: exp, log, sqrt, tanh, atan, sin, cos, abs, min, max, where",
        "x * exp(-0.2 * d)",
        maxlen=500,
    )


class ContactParameters(FunctionParameters):
    """Mixin: the parameters of the functions of contacts."""

    stiffness: number(
        "Stiffness (N/m)", "Stiffness of the layer: a foam mat under a chair's leg 10,000, a rubber pad 1,000,000", 1e5, (1e-3, 1e8)
    )
    load: number("Load", "Mass that the layer carries", 10.0, (1e-6, 1e4), unit="MASS")
    layer_loss: number(
        "Loss Factor",
        "Damping of the layer: rubber 0.1, foam 0.2; a greater one softens the resonance and passes more far above it",
        0.2,
        (0.0, 1.0),
    )
    fall_off: number("Fall-Off (dB)", "Loss per octave far above the resonance, in decibels; 12 for a spring", 12, (0, 48))
    reference: number("Reference (N)", "Force in newtons from which on everything passes", 10, (1e-6, 1e4))
    exponent: number("Exponent", "1/3: stiffness of smooth round bodies (Hertz); 1: of rough ones", 1 / 3, (0, 4), precision=3)
