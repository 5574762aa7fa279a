"""The tracers in C#, run by Mono, and in JavaScript, run by Node, against the conformance files and
the core."""

from __future__ import annotations

import json
import math
import shutil
import subprocess
import sys
from dataclasses import dataclass, field, replace
from pathlib import Path

import haptic_tracing as ht
import numpy as np
import pytest
from haptic_tracing.command_line.conformance import FOLDER, conversation
from haptic_tracing.core.contacts.contact_set import ContactSet
from haptic_tracing.core.contacts.shapes import Box, quaternions
from haptic_tracing.core.contacts.transmissions import TransmissionRules
from haptic_tracing.core.graph.haptic_graph import ObjectTable, build_graph
from haptic_tracing.core.graph.object_frames import ObjectFrames
from haptic_tracing.core.propagation import objects_on, propagate
from haptic_tracing.core.render.levels import LEVEL_SECONDS
from haptic_tracing.core.scene.functions import (
    Constant,
    Exponential,
    Expression,
    HapticTracing,
    Identity,
    Impedance,
    Linear,
    Physical,
    Resilient,
    Spectrum,
    Wave,
)
from haptic_tracing.core.scene.rule_table import Rule, RuleTable, Side
from haptic_tracing.core.scene.rules import ContactSettings
from haptic_tracing.core.scene.values import (
    Contact,
    HapticObject,
    HapticScene,
    Listener,
    Pose,
    Source,
    SourceKind,
)
from haptic_tracing.core.signals import Noise, Pulse, Sine
from haptic_tracing.plugins.engine import tables

ROOT = Path(__file__).parents[2]
pytestmark = [pytest.mark.slow, pytest.mark.plugins]


@pytest.fixture(scope="module", params=["C#", "JavaScript"])
def judge(request, tmp_path_factory):
    """The command that plays scripts to the tracer in a language."""
    here = Path(__file__).parent
    if request.param == "JavaScript":
        assert shutil.which("node"), "Node is missing"
        return ["node", here / "judge.mjs"]
    if not sys.platform.startswith("linux"):
        pytest.skip("Mono is installed on Linux only")
    assert shutil.which("mcs"), "Mono is missing: packaging/system_packages test"
    program = tmp_path_factory.mktemp("tracer") / "judge.exe"
    sources = [ROOT / "clients" / "csharp" / "HapticTracer.cs", here / "Judge.cs"]
    done = subprocess.run(
        ["mcs", "-warnaserror", "-langversion:7", f"-out:{program}", *sources],
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return ["mono", program]


def turned(vector):
    x, y, z = np.asarray(vector).tolist()
    return [x, z, -y]


@dataclass
class Script:
    """What a tracer is told; ``points``: contacts are points alone, without areas, as an engine tells
    them, with how far apart the surfaces are."""

    scene: ht.Scene | HapticScene
    points: bool = False
    lines: list[str] = field(default_factory=list)

    def __post_init__(self):
        self.content = getattr(self.scene, "content", self.scene)
        self.number = {item.name: k for k, item in enumerate(self.content.objects)}
        self.sources = {item.name: k for k, item in enumerate(self.content.sources)}
        self.listeners = {item.name: k for k, item in enumerate(self.content.listeners)}

    def tell(self, word, *values):
        numbers = (f"{float(value):.17g}".replace("nan", "NaN") for value in values)
        self.lines.append(" ".join([word, *numbers]))

    def place(self, names, transforms):
        for name, pose, turn in zip(
            names, transforms, quaternions(transforms[:, :3, :3]), strict=True
        ):
            w, *axis = turn.tolist()
            self.tell("move", self.number[name], *turned(pose[:3, 3]), w, *turned(axis))

    def touch(self, contacts: ContactSet, names, forces=None):
        self.tell("part")
        for k, pair in enumerate(contacts.pairs.tolist()):
            ends = [*turned(contacts.positions[k, 0]), *turned(contacts.positions[k, 1])]
            rest = contacts.area[k], math.nan, contacts.depth[k], contacts.weight[k]
            if self.points:
                middle = turned(contacts.positions[k].mean(axis=0))
                ends, rest = middle * 2, (0.0, math.nan, 0.0, contacts.weight[k])
            if forces is not None:
                rest = rest[0], forces[k], *rest[2:]
            self.tell(
                "touch",
                *(self.number[names[number]] for number in pair),
                *ends,
                *turned(contacts.normal[k]),
                *map(float, rest),
            )

    def read(self, path):
        self.lines.insert(0, f"read {tables.write(self.content, path)}")


def played(judge, lines):
    """The answers to the steps of a script."""
    done = subprocess.run(
        judge, input="\n".join(lines), capture_output=True, text=True, timeout=300
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return [json.loads(line) for line in done.stdout.splitlines()]


class Watched:
    """A run of the core whose frames are kept."""

    def __init__(self, scene):
        self.run = ht.open(scene, sample_rate=8000)
        step = self.run._tracer.step
        self.frame = self.result = None

        def kept(frame):
            self.frame, self.result = frame, step(frame)
            return self.result

        self.run._tracer.step = kept


def decibels(gain):
    return 20 * math.log10(gain) if gain > 0 else -math.inf


QUIET = -60.0
"""What is 20 dB under the threshold of feeling [dB] is not rendered by the core."""


def rms(gains):
    """Of gains by band."""
    return math.hypot(*gains) / math.sqrt(len(gains))


FAINT = 1e-6
"""Gains below that at which searches end are not compared."""

FILES = (
    "tone", "chain", "loop", "boxes", "one_shot", "mixed", "impact", "impact_of_the_engine",
    "sample_jackhammer_bench", "sample_hammer_nail", "sample_sliding_and_rolling",
)  # fmt: skip


@pytest.mark.parametrize("points", [False, True], ids=["contacts", "points"])
@pytest.mark.parametrize("name", FILES)
def test_conformance(name, points, judge, tmp_path):
    """With the contacts that the core finds all is as expected; from their points alone within
    a decibel."""
    (file,) = FOLDER.glob(f"{name}.json*")
    exchange = conversation(file)["exchange"]
    form = exchange[0]["send"]["scene"]
    scene = ht.loads(json.dumps({"format": "haptic-scene", "version": "1.1", **form}))
    core, script = Watched(scene), Script(scene, points)
    last, expected = None, []
    for one in exchange[1:]:
        sent = one["send"]
        if sent["type"] == "play":
            core.run.play(sent["source"])
            script.tell("play", script.sources[sent["source"]])
        if sent["type"] == "replace":
            break
        if sent["type"] != "step":
            continue
        given = {key: value for key, value in sent.items() if key not in ("type", "id", "time")}
        core.run.step(sent["time"], **given)
        result = core.result
        script.place(core.frame.names, core.frame.transforms)
        script.touch(result.contacts, result.objects)
        for source, state in given.get("sources", {}).items():
            amplitude = state.get(
                "amplitude", scene.content.sources[script.sources[source]].amplitude
            )
            script.tell("amplitude", script.sources[source], amplitude * state.get("playing", True))
        for kind in ("source", "listener"):
            for item in getattr(core.frame, f"{kind}s"):
                numbers = script.sources if kind == "source" else script.listeners
                if item.name in numbers:
                    script.tell(kind, numbers[item.name], *turned(item.position))
        for impact in result.impacts:
            one_name, other_name = (core.frame.names[k] for k in impact.objects)
            script.tell(
                "blow",
                script.number[one_name],
                script.number[other_name],
                *turned(impact.positions[0]),
                impact.energy,
                impact.time - (core.frame.time - sent["time"] + last),
            )
        script.tell("step", sent["time"] - (sent["time"] if last is None else last))
        last = sent["time"]
        expected.append((one.get("expect", {}), result))
    script.read(tmp_path / "scene.tracer.json")
    answers = played(judge, script.lines)
    calm = 0.0  # from when on levels are compared
    assert len(answers) == len(expected)
    limit = 1.0 if points else 0.01
    judged = 0
    for answer, (wanted, result) in zip(answers, expected, strict=True):
        if any(item.kind is SourceKind.TEMPORARY or item.rubs for item in result.sources):
            calm = result.time
        is_calm = result.time > calm + 1.2 * LEVEL_SECONDS
        judged += as_expected(answer, wanted, script, limit, is_calm)
        judged += blows_as_expected(answer, wanted, result, script, limit)
        judged += sources_as_the_core(answer, result, script, limit)
    assert judged


def as_expected(answer, wanted, script, limit, is_calm):
    """How many values are as the file says; levels of blows, of which the core varies each, of what
    slides, and of what is hardly felt are not compared."""
    judged = 0
    for listener, felt in wanted.get("levels", {}).items():
        column = script.listeners[listener]
        level = answer["levels"][column]
        for source, gain in felt.get("gains", {}).items():
            got = answer["sources"][script.sources[source]]["gains"][column]
            assert got == gain == 0 or decibels(got) == pytest.approx(decibels(gain), abs=limit)
            judged += 1
        if "felt" in felt:
            assert level is not None
        elif felt.get("level") is None:
            assert level is None or level < QUIET
        elif is_calm and felt["level"] > QUIET:
            assert level == pytest.approx(felt["level"], abs=limit)
        judged += 1
    return judged


def blows_as_expected(answer, wanted, result, script, limit):
    """How many values of the blows of a step are as the file and the core say."""
    first = len(result.sources) - len(result.impacts)
    blows = answer["blows"][len(answer["blows"]) - len(result.impacts) :]
    judged = 0
    for k, blow in enumerate(blows):
        expected = wanted.get("impacts", [{}] * len(blows))[k]
        if "amplitude" in expected:
            assert decibels(blow["amplitude"]) == pytest.approx(
                decibels(expected["amplitude"]), abs=0.01
            )
        for name, gain in expected.get("gains", {}).items():
            got = blow["gains"][script.listeners[name]]
            assert decibels(got) == pytest.approx(decibels(gain), abs=limit)
            judged += 1
        judged += as_the_core(blow, result, first + k, script, limit)
    return judged


def sources_as_the_core(answer, result, script, limit):
    """How many gains and paths are those of the core."""
    judged = 0
    for row, source in enumerate(result.sources):
        number = script.sources.get(source.name)
        if number is None:
            continue
        got = answer["sources"][number]
        for column, gain in enumerate(result.gains[row].tolist()):
            if gain > FAINT:
                assert decibels(got["gains"][column]) == pytest.approx(decibels(gain), abs=limit)
        judged += as_the_core(got, result, row, script, limit)
    return judged


def as_the_core(got, result, row, script, limit):
    """How many gains by lane and paths of a source are those of the core."""
    judged = 0
    found = result.propagation
    for column in range(len(result.listeners)):
        lanes = len(got["lanes"]) // len(result.listeners)
        gains = [found.gain[row, column]]
        if lanes > 1:
            bands = found.band_gain
            gains += gains * 6 if bands is None else bands[row, column].tolist()
        own = got["lanes"][column * lanes : (column + 1) * lanes]
        pairs = zip(own, gains, strict=True) if limit < 1 else [(rms(own), rms(gains))]
        for one, other in pairs:
            if other > FAINT:
                assert decibels(one) == pytest.approx(decibels(other), abs=limit)
                judged += 1
        names = [script.content.objects[k].name for k in got["paths"][column]]
        path = list(result.path_objects(row, column))
        if limit < 1 and found.gain[row, column] > FAINT:
            # A blow begins on both sides of its contact, from either as well if that passes all.
            both = -min(len(names), len(path)) if result.sources[row].second_object else 0
            assert names[both:] == path[both:]
    return judged


def random_function(pick, on_contact=False):
    """A function with random constants, of those for objects or for contacts."""
    spectrum = Spectrum(
        band_gains=tuple(pick.uniform(0.2, 1, 6)) if pick.random() < 0.2 else (),
        band_decays=tuple(pick.uniform(0, 0.3, 6)) if pick.random() < 0.2 else (),
        wave_speed=float(pick.uniform(50, 500)) if pick.random() < 0.3 else 0.0,
    )
    spring = Resilient(stiffness=10 ** pick.uniform(3, 6), loss_factor=pick.uniform(0, 0.5))
    choices = [
        Constant(gain_value=pick.uniform(0.3, 1), spectrum=spectrum),
        Exponential(alpha=pick.uniform(0.01, 1), spectrum=spectrum),
        HapticTracing(spectrum=spectrum),
        Resilient(frequency=pick.uniform(10, 200), loss_factor=pick.uniform(0, 0.5)),
        spring,
        Linear(range=pick.uniform(2, 20)),
        Expression(expression=f"1 / (1 + {pick.uniform(0.1, 2):.3f} * d)"),
    ]
    if on_contact:
        choices += [Impedance()] * 8 + [
            Identity(),
            Expression(expression="min(1, 0.3 + 20 * area)"),
            Expression(expression="kappa * exp(-d)"),
        ]
    else:
        choices += [physical(pick, spectrum) for _ in range(12)]
    return choices[pick.integers(len(choices))]


def physical(pick, spectrum):
    sizes = np.sort(10 ** pick.uniform(-2, 0.5, 3))
    return Physical(
        wave=list(Wave)[pick.choice(3, p=(0.7, 0.2, 0.1))],
        loss_factor=10 ** pick.uniform(-3, -0.5),
        phase_speed=10 ** pick.uniform(1.5, 3.7),
        density=10 ** pick.uniform(1.5, 3.9),
        thickness=sizes[0],
        extent=sizes[1],
        length=sizes[2],
        reference_distance=10 ** pick.uniform(-2, -0.5),
        material_k=pick.uniform(0.3, 0.9),
        spectrum=spectrum,
    )


def random_scene(seed):
    """Boxes with random functions that touch at random places, by rules in every other scene."""
    pick = np.random.default_rng(seed)
    count = pick.integers(2, 16)
    objects = [
        HapticObject(
            f"body {k:02}",
            *pick.uniform(0.2, 0.8, 2),
            propagation=random_function(pick),
            shape=Box(tuple(pick.uniform(0.005, 2, 3))),
            pose=Pose(tuple(pick.normal(0, 1, 3)), tuple(pick.normal(0, 1, 4))),
            mass=pick.uniform(0.1, 50),
            material=str(pick.choice(["steel", "wood", "flesh"])),
        )
        for k in range(count)
    ]
    pairs = {tuple(sorted(pick.choice(count, 2, replace=False).tolist())) for _ in range(2 * count)}
    contacts = []
    for a, b in sorted(pairs):
        place, normal = pick.normal(0, 1, 3), pick.normal(0, 1, 3)
        function = random_function(pick, on_contact=True)
        contacts.append(
            Contact(
                (objects[a].name, objects[b].name),
                (tuple(place), tuple(place + pick.normal(0, 0.01, 3))),
                transmission=function,
                area=pick.choice([0.0, 1e-3, 0.1]) * pick.uniform(0.5, 1),
                normal=tuple(normal / np.linalg.norm(normal)),
                weight=pick.choice([1.0, 0.5]),
            )
        )
    signals = [Sine(40.0), Sine(200.0), Pulse(30.0), Noise(0.5, seed=1)]
    ends = [
        (objects[pick.integers(count)].name, tuple(pick.normal(0, 1, 3).tolist())) for _ in range(7)
    ]
    return HapticScene(
        objects=tuple(objects),
        contacts=tuple(contacts),
        sources=tuple(
            Source(f"source {k}", *end, signal=signals[pick.integers(4)])
            for k, end in enumerate(ends[:3])
        ),
        listeners=tuple(
            Listener(f"listener {k}", *end, radius=pick.choice([0.0, 0.1]))
            for k, end in enumerate(ends[3:])
        ),
        rules=ContactSettings(
            transmission_table=RuleTable(
                (
                    Rule((Side(material="steel"), Side()), random_function(pick, on_contact=True)),
                    Rule((Side(object="body 01"), Side()), random_function(pick, on_contact=True)),
                )
            )
        ),
    )


def test_random_scenes(judge, tmp_path):
    """Gains by lane, delays and paths of a hundred scenes are those of the core."""
    lines, expected = [], []
    for seed in range(100):
        scene = random_scene(seed)
        table = ObjectTable.of(scene.objects, scene.settings.epsilon)
        contacts = ContactSet.from_contacts(scene.contacts, table.index())
        if seed % 2:  # their functions by the rules
            named = [(item.name, item.material) for item in table.objects]
            contacts = TransmissionRules(scene.rules.transmission_table, named).over(
                replace(
                    contacts,
                    transmission=np.zeros(len(contacts), dtype=np.int64),
                    transmissions=(Impedance(),),
                )
            )
        graph = build_graph(
            table, contacts, scene.sources, scene.listeners, ObjectFrames.of_objects(table.objects)
        )
        found = propagate(graph, scene.settings)
        script = Script(replace(scene, contacts=()) if seed % 2 else scene)
        if seed % 2:
            script.touch(contacts, table.names)
        script.tell("step", 0.01)
        script.read(tmp_path / f"{seed}.tracer.json")
        lines += script.lines
        expected.append((graph, found))
    judged = 0
    for seed, (answer, (graph, found)) in enumerate(
        zip(played(judge, lines), expected, strict=True)
    ):
        for row, got in enumerate(answer["sources"]):
            own = np.array(got["lanes"]).reshape(found.gain.shape[1], -1)
            for column, lanes in enumerate(own):
                gains = [found.gain[row, column]]
                if found.band_gain is not None:
                    gains += found.band_gain[row, column].tolist()
                for one, other in zip(lanes, gains, strict=False):
                    if other > FAINT:
                        assert decibels(one) == pytest.approx(decibels(other), abs=0.02), seed
                        judged += 1
                path = objects_on(graph, found.best_path.get((row, column), ()))
                names = [table_name(graph, k) for k in got["paths"][column]]
                assert names == list(path) or max(gains) < FAINT, seed
                late = 0.0 if found.delay is None else found.delay[row, column]
                assert got["delays"][column] / 8000 == pytest.approx(late, abs=1e-6), seed
    assert judged > 1000


def table_name(graph, number):
    """The name of an object by its number in the tables; scenes list objects by their names."""
    return graph.table.names[number]
