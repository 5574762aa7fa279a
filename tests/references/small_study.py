"""A small study with people: one item, nothing excluded but what is incomplete or all alike."""

import json
import threading
from contextlib import contextmanager
from types import SimpleNamespace

import numpy as np
from haptic_tracing.core.devices.mapping import map_listeners
from haptic_tracing.core.devices.profile_files import profile
from haptic_tracing.core.devices.status import Status
from haptic_tracing.core.formats.tracks.listener_tracks import ListenerTrack, Tracks
from haptic_tracing.core.formats.tracks.wav import described, write_wav

RATE, SECONDS = 8000, 2.0
FORM = """
title = "T"
smallest_effect = 0.5
consent = "C"
instructions = "I"
about = {}
words = []
scale = {low = 1, high = 5}
items = [{factor = "Realism", text = "R"}]
exclusion = {incomplete = true, same_answers = true, seconds_per_item = 0, missed_ms = 500}
"""
"""To be followed by ``conditions`` and ``scenes``."""


@contextmanager
def served(folder):
    """The pages of a study of two buzzes, whose pad keeps a ``log`` of what it is told."""
    from haptic_tracing.command_line.study_run import Study
    from haptic_tracing.study.people.plan import read_form

    (folder / "study.toml").write_text(
        FORM
        + """conditions = {one = {}, two = {}}
scenes = {buzz = {tracks = {one = "one.wav", two = "two.wav"}}}
"""
    )
    times = np.arange(round(RATE * SECONDS)) / RATE
    tracks = Tracks(
        (ListenerTrack("Hand", "hand.L"),), RATE, 0.5 * np.sin(2 * np.pi * 160 * times)[None]
    )
    for name in ("one", "two"):
        write_wav(tracks, folder / f"{name}.wav")
        (folder / f"{name}.wav.json").write_text(json.dumps(described(tracks)))
    log = []
    pad = SimpleNamespace(
        profile=profile("dualsense"),
        status=Status("open"),
        send=lambda block, due=None: log.append("block"),
        expect=lambda block, due: None,
        wait_until_open=lambda seconds: None,
    )
    stage = SimpleNamespace(
        outputs={"pad": pad},
        mapping=lambda parts: map_listeners(parts, {"pad": pad.profile}),
        stop=lambda: log.append("silence"),
    )
    study = Study(folder, read_form(folder), 2, stage)
    study.log = log
    with study.listen(0) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield study
        server.shutdown()
