"""Materials: enough of them, within their ranges, different from each other; guesses from names,
shapes and masses."""

import math
import unicodedata

import pytest
from haptic_tracing.core.scene.functions import HapticTracing, Spectrum
from haptic_tracing.core.scene.materials import MATERIALS, absorption, guess, named_in
from hypothesis import example, given, settings
from hypothesis import strategies as st


def test_there_are_the_materials_that_designers_ask_for():
    wanted = [
        "stone",
        "hardwood",
        "softwood",
        "steel",
        "glass",
        "rubber",
        "soil",
        "sand",
        "concrete",
        "fabric",
        "ribbon",
        "flesh",
        "bone",
        "water",
        "air",
    ]
    assert set(wanted) <= set(MATERIALS)
    assert len(MATERIALS) >= 20


@pytest.mark.parametrize("material", MATERIALS.values(), ids=MATERIALS)
def test_values_make_a_function(material):
    assert 0 < material.kappa < 1
    assert 0 < material.rho <= 1
    assert 0.02 < material.k < 0.95
    function = HapticTracing(spectrum=Spectrum(wave_speed=material.wave_speed))
    assert 0 < function.gain(1.0, material.kappa, material.rho, 0.1) < 1
    assert material.words[0] == material.name


def test_no_word_means_two_materials():
    words = [
        word for material in MATERIALS.values() for word in (*material.words, *material.things)
    ]
    assert len(words) == len(set(words))


def test_absorption_is_that_of_a_lossy_plane_wave():
    """exp(i k x) with k = (omega / c) (1 + i eta / 2): the amplitude falls by the imaginary
    part."""
    eta, speed = 0.06, 200.0
    k = 2 * math.pi * 100.0 / (speed * (1 - 1j * eta) ** 0.5)
    assert absorption(eta, speed) == pytest.approx(abs(k.imag) * (1 + eta**2) ** 0.5, rel=5e-3)


@pytest.mark.parametrize(
    ("name", "material"),
    [
        ("Oak Bench.001", "hardwood"), ("rusty_metal_2", "steel"), ("WoodenCrate", "softwood"), ("Steinmauer", "stone"), ("Stein", "stone"),
        ("Ground", "soil"), ("Cube", None), ("Airplane", None), ("Metallic", "steel"), ("GLASS", "glass"), ("Character_Body", "flesh"),
        ("", None),
        ("Floor", "concrete"), ("Wooden Floor", "softwood"), ("Floorboards", "softwood"), ("Fußboden", "concrete"),
        ("Forest Ground", "soil"),
        ("Glass Table", "glass"), ("Oak Plank", "hardwood"), ("Anvil", "steel"), ("Rocky cliff", "stone"), ("tiles.012", "ceramic"),
    ],
)  # fmt: skip
def test_names_tell_the_material(name, material):
    found = named_in(name)
    assert (found.name if found else None) == material


def test_shape_and_mass_tell_where_no_name_does():
    assert guess(["Plane"], (20.0, 10.0, 0.0)).name == "soil"
    assert guess(["Cube"], (1.0, 1.0, 1.0), 7500.0).name == "steel"
    assert guess(["Cube"], (1.0, 1.0, 1.0), 30.0).name == "foam"
    assert guess(["Cube"], (2.0, 2.0, 2.0)) is None
    assert guess(["Cube"]) is None
    assert guess(["Plane", "Old Marble"], (20.0, 10.0, 0.0)).name == "stone"


@settings(derandomize=True, deadline=None)
@example([], (16.0, 3e4, 2e5), 2e-313)
@given(
    st.lists(st.text(max_size=30), max_size=3),
    st.tuples(*[st.floats(0, 1e6)] * 3),
    st.none() | st.floats(0, 1e9),
)
def test_anything_may_be_guessed_at(names, size, mass):
    found = guess(names, size, mass)
    assert found is None or found.name in MATERIALS


@pytest.mark.parametrize(
    ("names", "material"),
    [
        # EN 10025, EN 10027-2, EN 10027-1, AISI, DIN 17100, EN 10346, EN 1561
        ("S235 S235JR S355J2+N S235_zinc 1.4301 1.0038 X5CrNi18-10 42CrMo4 AISI_304 316L "
         "St37-2 DX51D+Z275 EN-GJL-250 C45 galvanised_bolt B500B verzinkt Inox tin_can", "steel"),
        ("AlSi10Mg AlMg3 EN_AW-6060 6061-T6 3.2315 Al AZ91D", "aluminium"),  # EN 573, EN 1706
        ("CuZn37 CW614N 2.0401 Zinc zink Zamak-5 Cu", "brass"),  # EN 12164, EN 1774
        ("Pb lead Blei", "lead"),
        # ISO 1043-1
        ("ABS ABS_black PA66 PA66-GF30 PA6.6 PA12 POM POM-C PC PMMA PETG HDPE PE-HD PP PTFE PEEK "
         "PVC polycarbonate GFK", "plastic"),
        ("NBR NBR70 EPDM FKM SBR TPU TPE neoprene O-Ring_NBR", "rubber"),  # ISO 1629
        ("MDF OSB OSB/3 HDF", "plywood"),  # EN 316, EN 300
        ("C30/37 C25-30 LC25/28 Stahlbeton Estrich", "concrete"),  # EN 206
        ("C24 GL24h BSH Timber", "softwood"),  # EN 338, EN 14080
        ("EPS XPS styrofoam", "foam"),
        ("GKB Plasterboard", "plaster"),
        # JIS G 3101, G 4303, G 4051, GB/T 700, EN 10365, DIN 17100
        ("SS400 SUS304 S45C Q235B HEB200 IPE_300 V2A St37", "steel"),
        ("EN_AW-6082 A6061-T6 AL7075 ADC12 Alublech", "aluminium"),  # EN 573, JIS H 5302
        ("PVC-U PE100 CarbonFibre Makrolon", "plastic"),  # ISO 1043-1, EN 12201
        ("ESG_8mm VSG Floatglas", "glass"),  # EN 12150, EN 14449
        ("MDF_19mm Sperrholz_Birke Particle_Board", "plywood"),  # EN 316, EN 313, EN 309
    ],
)  # fmt: skip
def test_designations_of_standards_and_trade_names_are_known(names, material):
    for name in names.split():
        for text in (name, f"{name}.001", f"M_{name}", f"Housing {name}"):
            found = named_in(text)
            assert found is not None and found.name == material, text


@pytest.mark.parametrize(
    "name",
    ["Tiny", "Part 304", "Render 2024", "GRP_Part", "C10", "hips", "Group UP", "Version 5.6"],
)
def test_numbers_and_other_words_are_no_designations(name):
    assert named_in(name) is None


@pytest.mark.parametrize(
    ("names", "material"),
    [
        ("Stahlträger Cortenstahl STEELPLATE acier Acciaio acero staal 不锈钢 金属", "steel"),
        ("Kupferrohr cuivre latón 真鍮", "brass"),
        ("Holztisch woodfloor bois legno madera hout 木材", "softwood"),
        ("Eichenholz cherry_wood WoodOak chêne quercia roble", "hardwood"),
        ("Betonwand Sichtbeton béton calcestruzzo hormigón 混凝土", "concrete"),
        ("Glasscheibe verre vetro vidrio ガラス", "glass"),
        ("Gummimatte caoutchouc gomma goma ゴム", "rubber"),
        ("Kunststoffgehäuse plastique plástico プラスチック", "plastic"),
        ("Steinmauer Cobblestone pierre pietra piedra mármol", "stone"),
        ("Backsteinwand brickwall brique mattone ladrillo", "brick"),
    ],
)  # fmt: skip
def test_words_of_other_languages_and_in_longer_words_are_known(names, material):
    """As imports name materials; macOS writes letters and accents apart in names of files."""
    for name in names.split():
        for text in (name, f"{name}_01", f"MI_{name}", unicodedata.normalize("NFD", name)):
            found = named_in(text)
            assert found is not None and found.name == material, text


@pytest.mark.parametrize("name", ["Leader", "Rocket", "Sandwich", "Goldfish", "Arena"])
def test_other_words_have_no_parts_that_tell(name):
    assert named_in(name) is None
