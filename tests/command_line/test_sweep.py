"""Sweeps as they are typed, with a worker killed on the way; what they refuse; and what is read out
of a table."""

import json
import math
import os
import subprocess
import sys
import time

import bpy
import numpy as np
import pytest
from haptic_tracing.addon.session import timeline
from haptic_tracing.command_line import main
from haptic_tracing.core.formats.tracks.track_recorder import TrackRecorder
from haptic_tracing.core.scene.values import SourceKind
from haptic_tracing.sample_scenes import build_sample
from scipy.io import wavfile

psutil = pytest.importorskip("psutil", reason="haptic-tracing[sweep] is not installed")
pytest.importorskip("pyarrow", reason="haptic-tracing[sweep] is not installed")
distributed = pytest.importorskip("distributed", reason="haptic-tracing[sweep] is not installed")

from haptic_tracing.command_line import sweep
from haptic_tracing.command_line.sweep import checking, scheduling, table
from haptic_tracing.command_line.sweep.study import SweepStudy, Variant, read_study
from haptic_tracing.core.formats.io.error import FormatError


def write_results(path, milliseconds, listeners):
    path.write_text(json.dumps({"milliseconds": milliseconds, "frames": 3, "listeners": listeners}))


@pytest.fixture(scope="module")
def folder(registered, tmp_path_factory):
    """That of ``bench.blend``: the bench and a jackhammer."""
    folder = tmp_path_factory.mktemp("sweep")
    build_sample("jackhammer_bench")
    bpy.ops.wm.save_as_mainfile(filepath=str(folder / "bench.blend"))
    return folder


@pytest.fixture
def scene(folder):
    """The bench, opened with the add-on enabled."""
    bpy.ops.wm.open_mainfile(filepath=str(folder / "bench.blend"))
    return bpy.context.scene


def seat(scene):
    """The object on the path from the jackhammer to the avatar."""
    return next(obj for obj in scene.objects if obj.haptics.enabled and "seat" in obj.name.lower())


def kill_one_worker(process, results):
    """Kill a worker that has a task, once there is a result."""
    while not list(results.glob("*.json")):
        assert process.poll() is None
        time.sleep(0.05)
    for child in psutil.Process(process.pid).children(recursive=True):
        if "haptic_tracing.command_line.sweep.task" in child.cmdline():
            child.parent().kill()
            return
    raise AssertionError("no worker has a task")


def vibration_level(samples, rate):
    """The level of samples without the mean of at least a quarter of a second, into which shorter
    ones are placed in silence."""
    padded = np.pad(samples, (0, max(round(rate / 4) - len(samples), 0)))
    return 10 * math.log10(np.sum((padded - padded.mean()) ** 2) / len(samples))


@pytest.mark.slow
def test_a_killed_worker_loses_nothing_and_blender_alone_gives_the_same_bits(
    scene, folder, command, tmp_path, capsys
):
    path = f'objects["{seat(scene).name}"].haptics.kappa'
    study = folder / "kappa.toml"
    study.write_text(
        f"scenes = ['bench.blend']\nframes = [1, 4]\n[settings]\n'{path}' = [0.1, 0.6]\n"
    )
    two = ["sweep", str(study), "--workers", "2", "--tracks", "--out", str(tmp_path / "two")]
    program = [sys.executable, "-m", "haptic_tracing", *two]
    process = subprocess.Popen(program, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    kill_one_worker(process, tmp_path / "two" / "kappa" / "results")
    said, complaint = process.communicate()
    assert process.returncode == 0, complaint
    assert "2 variants, 2 of them new" in said
    rows = table.read_table(tmp_path / "two" / "kappa.parquet").to_pylist()
    assert [row[path] for row in rows[:: len(rows) // 2]] == [0.1, 0.6]

    # What is there is not traced again.
    written = {file: file.stat().st_mtime_ns for file in (tmp_path / "two" / "kappa").rglob("*.*")}
    assert command(*two) == 0
    assert "2 variants, 0 of them new" in capsys.readouterr().out
    assert written == {
        file: file.stat().st_mtime_ns for file in (tmp_path / "two" / "kappa").rglob("*.*")
    }

    # Blender gives the same bits without any worker.
    bpy.ops.wm.open_mainfile(filepath=str(folder / "bench.blend"))
    scene = bpy.context.scene
    for key, kappa in {row["key"]: row[path] for row in rows}.items():
        seat(scene).haptics.kappa = kappa
        recorder = TrackRecorder()
        traced = [step.result for step in timeline.steps(scene, 1, 5)]
        for result in traced:
            recorder.add(result)
        samples = wavfile.read(tmp_path / "two" / "kappa" / "tracks" / f"{key}.wav")[1]
        assert np.array_equal(samples, recorder.tracks().samples.T)

    # Levels are those of the tracks, gains the means of the frames.
    number = {name: k for k, name in enumerate(dict.fromkeys(row["listener"] for row in rows))}
    for row in rows:
        samples = wavfile.read(tmp_path / "two" / "kappa" / "tracks" / f"{row['key']}.wav")[1][
            :, number[row["listener"]]
        ]
        assert row["level"] == pytest.approx(vibration_level(samples.astype("f8"), 8000), abs=1e-9)
        assert row["peak"] == np.abs(samples).max()
    for row in (row for row in rows if row[path] == 0.6):
        gains = {s.name: [] for s in traced[0].sources if s.kind is SourceKind.PERSISTENT}
        for result in traced:
            for s, source in enumerate(result.sources):
                if source.name in gains:
                    gains[source.name].append(result.amplitudes[s, number[row["listener"]]])
        assert dict(row["gains"]) == pytest.approx(
            {name: np.mean(values) for name, values in gains.items()}, rel=1e-12
        )


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("scenes = [", "not TOML"),
        ("scenes = []", "/scenes: must have at least 1 item, has 0"),
        ("scenes = ['gone.blend']", "there is no file"),
        (
            "scenes = ['bench.blend']\nsetings = {}",
            "/setings: unknown key, did you mean .settings.",
        ),
        ("scenes = ['bench.blend']\nframes = [9, 2]", "frames: must be"),
        ("scenes = ['bench.blend']\nmodes = ['XX']", "/modes/0: must be one of HT"),
        ("scenes = ['bench.blend']\nseeds = ['a']", '/seeds/0: must be an integer, got "a"'),
        (
            "scenes = ['bench.blend']\n[materials]\nBench = ['cheese']",
            "Bench: must be some of .*, not cheese",
        ),
        (
            "scenes = ['bench.blend']\n[random]\n'scene.haptics.minimum_energy' = [0, 1]",
            r"seeds: \[random\] draws one value for each seed",
        ),
        ("scenes = ['bench.blend']\n[settings]\na = 3", "/settings/a: must be an array, got 3"),
        (f"scenes = ['bench.blend']\nseeds = [{2**63}]", r"study.toml: /seeds/0: must be at most"),
        (
            f"scenes = ['bench.blend']\n[settings]\na = [{2**63}]",
            r"study.toml: /settings/a/0: must be at most",
        ),
        ("scenes = ['bench.blend']\n[settings]\na = [nan]", "not TOML: nan is no number"),
        (
            "scenes = ['bench.blend']\nseeds = [1979-05-27]",
            '/seeds/0: must be an integer, got "1979-05-27"',
        ),
        (
            f"scenes = ['bench.blend']\nseeds = {'[' * 300}{']' * 300}",
            "nested deeper than 100 levels|nested too deeply|not TOML",
        ),
        (f"scenes = ['bench.blend']\n{'k' * 5000} = 1", "study.toml: /kkk"),
        (
            f"scenes = ['bench.blend']\nseeds = {list(range(100_001))}\n",
            "100001 variants are more than 100000",
        ),
    ],
)
def test_studies_that_cannot_be_read(tmp_path, text, said):
    (tmp_path / "bench.blend").touch()
    (tmp_path / "study.toml").write_text(text)
    with pytest.raises(FormatError, match=said) as caught:
        read_study(tmp_path / "study.toml")
    assert (
        str(caught.value).startswith(f"{tmp_path / 'study.toml'}: ")
        and len(str(caught.value)) < 700
    )


def study_of(**more):
    empty = {
        "scenes": (),
        "frames": None,
        "modes": (),
        "seeds": (),
        "settings": {},
        "materials": {},
        "random": {},
    }
    return SweepStudy(**{**empty, **more})


@pytest.mark.parametrize(
    ("more", "said"),
    [
        ({"settings": {"scene.haptics.treshold": [0.0]}}, "there is no scene.haptics.treshold"),
        (
            {"settings": {"scene.haptics.minimum_energy": [0.1, -2.0]}},
            "^scene.haptics.minimum_energy=-2.0: must be ",
        ),
        ({"random": {"scene.haptics.minimum_energy": [-2.0, -0.1]}, "seeds": (1,)}, "must be "),
        ({"materials": {"Gone": ["steel"]}}, "there is no object 'Gone'"),
    ],
)
def test_studies_that_do_not_fit_their_scene(scene, more, said):
    with pytest.raises(ValueError, match=said):
        checking._check_values(scene, study_of(**more))


def test_every_combination_is_a_variant_and_a_seed_draws_within_its_range(tmp_path):
    (tmp_path / "a.blend").write_bytes(b"a")
    (tmp_path / "b.blend").write_bytes(b"b")
    (tmp_path / "study.toml").write_text(
        "scenes = ['a.blend', 'b.blend']\nmodes = ['HT', 'SD']\nseeds = [1, 2, 3]\n"
        "[settings]\nx = [1, 2]\n[materials]\nC = ['steel', 'ice']\n[random]\ny = [-2.0, 5.0]\n"
    )
    study = read_study(tmp_path / "study.toml")
    variants = list(study.variants())
    assert len(variants) == study.count == 2 * 2 * 3 * 2 * 2
    assert len({variant.key("") for variant in variants}) == len(variants)
    drawn = {
        variant.seed: {other.settings["y"] for other in variants if other.seed == variant.seed}
        for variant in variants
    }
    assert all(len(values) == 1 and -2 <= min(values) <= 5 for values in drawn.values())
    assert len(set.union(*drawn.values())) == 3


def test_disks_without_room_are_refused(tmp_path):
    with pytest.raises(ValueError, match=r"need about .* MB, and .* MB are free"):
        sweep._make_folders(tmp_path, 100_000, 1e18)


@pytest.mark.slow
def test_clusters_that_do_not_answer_are_refused():
    with (
        pytest.raises(ValueError, match=r"--on tcp://127\.0\.0\.1:9: no scheduler answers"),
        scheduling.connected("tcp://127.0.0.1:9", 1),
    ):
        pass


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:Mismatched versions")
def test_workers_with_other_versions_and_clusters_without_workers_are_refused(tmp_path):
    fake = tmp_path / "numpy-0.0.1.dist-info"
    fake.mkdir()
    (fake / "METADATA").write_text("Metadata-Version: 2.1\nName: numpy\nVersion: 0.0.1\n")
    with distributed.LocalCluster(n_workers=0, dashboard_address=None) as cluster:
        address = cluster.scheduler_address
        with (
            pytest.raises(ValueError, match="has no worker: start some by: dask worker"),
            scheduling.connected(address, 1),
        ):
            pass
        environment = {
            **os.environ,
            "PYTHONPATH": os.pathsep.join([str(tmp_path), os.environ.get("PYTHONPATH", "")]),
        }
        worker = subprocess.Popen(
            [sys.executable, "-m", "dask", "worker", address, "--no-dashboard"],
            env=environment,
            stderr=subprocess.DEVNULL,
            cwd=tmp_path,
        )
        try:
            with distributed.Client(address, set_as_default=False) as client:
                client.wait_for_workers(1)
            with (
                pytest.raises(ValueError, match=r"worker .* has .*numpy 0\.0\.1; this machine has"),
                scheduling.connected(address, 1),
            ):
                pass
        finally:
            worker.terminate()
            worker.wait()


@pytest.mark.slow
def test_the_scheduler_knows_of_a_few_tasks_and_may_go(tmp_path):
    tasks = [
        {"key": str(number)} for number in range(20)
    ]  # each fails at once, as there is no variant in it
    with distributed.LocalCluster(
        n_workers=1, threads_per_worker=1, dashboard_address=None, processes=False
    ) as cluster:
        done = scheduling.run_all(cluster.scheduler_address, 1, tasks)
        for _ in range(2):
            assert "variant" in next(done)[1]
            assert len(cluster.scheduler.tasks) <= 5  # four, and the one that is being forgotten
        cluster.close()
        with pytest.raises(ValueError, match="the scheduler has gone; what is done is kept"):
            list(done)


@pytest.fixture
def results(tmp_path):
    """A table of three variants of two listeners."""
    (tmp_path / "results").mkdir()
    keyed = []
    for number, (kappa, rms, milliseconds) in enumerate(
        [(0.1, 0.1, 1.0), (0.5, 0.01, 2.0), (0.9, 0.001, 3.0)]
    ):
        listeners = [
            {
                "listener": name,
                "body_part": "",
                "rms": rms * scale,
                "peak": rms,
                "impacts": 0,
                "gains": {"saw": rms},
                "silenced": False,
            }
            for name, scale in (("hand", 1.0), ("foot", 10.0))
        ]
        (tmp_path / "results" / f"{number}.json").write_text(
            json.dumps({"milliseconds": milliseconds, "frames": 3, "listeners": listeners})
        )
        keyed.append(
            (
                str(number),
                Variant("a.blend", "", None, None, None, {"kappa": kappa, "kind": "x"}, {}),
            )
        )
    keyed.append(("failed", Variant("a.blend", "", None, None, None, {"kappa": 1, "kind": 2}, {})))
    table.write_table(tmp_path / "table.parquet", tmp_path, keyed)
    return tmp_path / "table.parquet"


def test_a_table_has_a_row_for_each_variant_and_listener(results):
    rows = table.read_table(results).to_pylist()
    assert [(row["kappa"], row["listener"], round(row["level"], 9)) for row in rows] == [
        (0.1, "hand", -20), (0.1, "foot", 0), (0.5, "hand", -40), (0.5, "foot", -20), (0.9, "hand", -60), (0.9, "foot", -40),
    ]  # fmt: skip


@pytest.mark.slow
def test_plot_draws_and_answers(results, tmp_path, capsys):
    assert main(["sweep", "plot", str(results), "--out", str(tmp_path)]) == 0
    assert "wrote" in capsys.readouterr().out
    assert {path.name for path in tmp_path.glob("*.svg")} == {"table.levels.svg"}


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--over", "rho"], "has no column rho; it has scene, kappa, kind"),
    ],
)
def test_plots_that_cannot_be_drawn(results, tmp_path, capsys, arguments, said):
    assert main(["sweep", "plot", str(results), "--out", str(tmp_path / "out"), *arguments]) == 2
    assert said in capsys.readouterr().err
    (tmp_path / "no.parquet").write_bytes(b"PAR1")
    assert main(["sweep", "plot", str(tmp_path / "no.parquet")]) == 2
    assert "not Parquet" in capsys.readouterr().err
