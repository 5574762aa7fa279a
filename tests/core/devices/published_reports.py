"""Published reports of devices, in a file `hid_golden.json`, and what is compared with them."""

import json
import math
from pathlib import Path

import numpy as np
from haptic_tracing.command_line import main
from haptic_tracing.command_line.devices import rumble_report


def published(module):
    """The file beside a module."""
    return json.loads(Path(module).with_name("hid_golden.json").read_text())


def vectors_of(module):
    """Its reports by name."""
    return {vector["id"]: vector for vector in published(module)["vectors"]}


def rumble(name, transport=None, left=0.5, right=0.25, sequence=0):
    return rumble_report(name, left, right, transport, sequence).data


def pcm(family, vector):
    """A vector's samples: both actuators in step, or one after the other."""
    given = vector["input"]
    if "samples" in given and isinstance(given["samples"], list):
        samples = np.array(given["samples"], dtype=np.int8).reshape(-1, 2).T
    elif "left_samples" in given:
        samples = np.array([given["left_samples"], given["right_samples"]], dtype=np.int8)
    else:
        samples = np.zeros((2, family.frames), dtype=np.int8)
    return family.encode(samples, given.get("ctr", 0)).data


def tone_of(vector, frames, rate):
    """The vector's tone in samples, from its description."""
    given = vector["input"]
    phase = 2 * math.pi * given["freq_hz"] / rate
    return [
        [round(given[side] * 127 * math.sin(phase * n)) for n in range(frames)]
        for side in ("left", "right")
    ]


def check(report, vector):
    """The report is that of the vector, to the byte."""
    assert report.hex() == vector["hex"]
    assert len(report) == vector["length"]


def check_printed(capsys, device, options, vector):
    """``devices encode`` prints it. A vector may end with the last byte that means something; the
    rest of the report is padding."""
    command = ["devices", "encode", device, *options.split(), "--left", "0.5", "--right", "0.25"]
    assert main(command) == 0
    printed = capsys.readouterr().out.rstrip("\n")
    assert printed.startswith(vector["hex"]) and set(printed[len(vector["hex"]) :]) <= {"0"}
