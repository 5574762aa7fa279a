"""Properties of the physical propagation function: material parameters and wave type."""

from __future__ import annotations

from .kinds import choice, limited, number

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
