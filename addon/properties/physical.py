"""Properties of the physical propagation function: what a body is made of and how vibration travels in it."""

from __future__ import annotations

from bpy.props import EnumProperty, FloatProperty

from .callbacks import edited

WAVE_ITEMS = (
    ("rod", "Rod", "Along a rod, a string or a small body: no spreading"),
    ("plate", "Plate", "Bending waves in a plate of a thickness, which spread over its surface"),
    ("surface", "Ground", "Waves along the surface of the ground"),
    ("solid", "Solid", "Through a volume, in all directions"),
    ("limb", "Limb", "Along a part of a body, which moves as a whole up to its resonance"),
)


class PhysicalParameters:
    """Mixin: the parameters of the physical function."""

    wave: EnumProperty(
        name="Wave", description="How vibration travels in the body", items=WAVE_ITEMS, default="solid", update=edited("wave")
    )
    loss_factor: FloatProperty(
        name="Loss Factor",
        description="Part of the energy that a cycle turns into heat, over 2π: steel 0.0002, wood 0.01, rubber 0.15",
        default=0.01,
        min=0.0,
        soft_max=1.0,
        precision=5,
        update=edited("loss_factor"),
    )
    phase_speed: FloatProperty(
        name="Speed (m/s)",
        description="Speed of the waves in metres per second, for plates that of extensional waves: steel 5100, soil 200",
        default=1000.0,
        min=0.1,
        soft_max=6000.0,
        update=edited("phase_speed"),
    )
    density: FloatProperty(
        name="Density (kg/m³)",
        description="With the speed it gives the impedance that contacts may depend on: steel 7850, water 1000, foam 40",
        default=1000.0,
        min=0.1,
        soft_max=20000.0,
        update=edited("density"),
    )
    plate_thickness: FloatProperty(
        name="Thickness",
        description="Thickness of the plate",
        default=0.1,
        min=1e-4,
        soft_max=1.0,
        unit="LENGTH",
        precision=4,
        update=edited("plate_thickness"),
    )
    absorption: FloatProperty(
        name="Joints (1/m)",
        description="Attenuation per metre that edges and joints add at every frequency; walls and floors of a building 0.12 to 0.35",
        default=0.0,
        min=0.0,
        soft_max=1.0,
        precision=3,
        update=edited("absorption"),
    )
    material_k: FloatProperty(
        name="Material K",
        description="(1 - κ) ρ at which the numbers above hold; a lower one damps more, a higher one less",
        default=0.5,
        min=0.01,
        max=0.99,
        precision=3,
        update=edited("material_k"),
    )
    reference_distance: FloatProperty(
        name="Source Radius",
        description="Radius of the region that a source drives; spreading begins there",
        default=0.5,
        min=0.001,
        soft_max=10.0,
        unit="LENGTH",
        update=edited("reference_distance"),
    )
    extent: FloatProperty(
        name="Extent",
        description="Distance over which vibration spreads in the body, its own length; 0: without end",
        default=0.0,
        min=0.0,
        soft_max=100.0,
        unit="LENGTH",
        update=edited("extent"),
    )
    resonance: FloatProperty(
        name="Resonance (Hz)",
        description="A limb moves as a whole up to this frequency: trunk 5, elbow 8, knee 25, wrist 30, fingertip 200",
        default=20.0,
        min=0.0,
        soft_max=300.0,
        update=edited("resonance"),
    )
