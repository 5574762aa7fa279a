"""Runs inside umockdev: the pages of a study with a pad for each hand, whose reports are timed.

Prints where the pages are. Called as ``umockdev-run ... -- python laboratory.py FOLDER``.
"""

import os
import signal
import sys
from dataclasses import replace
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "core" / "devices"))

from haptic_tracing.command_line.serve.stage import DeviceStage
from haptic_tracing.command_line.study_run import Study
from haptic_tracing.core.devices.guard import DeviceOutput
from haptic_tracing.core.devices.profile_files import profile
from haptic_tracing.study.people.plan import read_form
from timed_hid import TimedHid

folder = Path(sys.argv[1])
log = folder / "log"
log.mkdir(exist_ok=True)
signal.signal(signal.SIGTERM, lambda *_: sys.exit(0))
left, right = profile("dualsense").actuators
calibrated = replace(left, full_scale=((100.0, 20.0),))
pads = (replace(profile("dualsense"), actuators=(calibrated, right)), profile("xbox"))
stage = DeviceStage(
    {
        pad.name: DeviceOutput(replace(pad, slew=10_000.0), hid=TimedHid(str(log)), rate=8000)
        for pad in pads
    }
)
try:
    study = Study(folder, read_form(folder), 4, stage)
    with study.listen(0) as server:
        print(*study.pages, os.getpid(), "", sep="\n", flush=True)
        server.serve_forever()
finally:
    stage.close()
