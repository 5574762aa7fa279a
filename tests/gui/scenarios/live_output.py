"""A made-up DualSense is felt while the timeline plays, and is silent and released at pause, undo,
panic and another file."""

import sys

import bpy

ZERO = bytes([2, 2]) + bytes(37) + bytes([4]) + bytes(8)
RELEASE = bytes([2]) + bytes(47)

# In the place of hidapi's module, in Blender, which looks for devices, and in the guard process,
# which writes to them.
MODULE = """
from pathlib import Path
from types import SimpleNamespace


def enumerate(*_):
    names = {"serial_number": "", "product_string": "Made up"}
    numbers = {"vendor_id": 0x054C, "product_id": 0x0CE6, "usage_page": 1, "usage": 5, "interface_number": 3, "bus_type": 1}
    return [{"path": b"/dev/null", **names, **numbers}]


def log(line):
    with open(Path(__file__).with_name("reports"), "a") as file:
        file.write(line + "\\n")


def write(data):
    log(bytes(data).hex())
    return len(data)


def device():
    return SimpleNamespace(
        open_path=lambda path: None,
        write=write,
        send_feature_report=write,
        get_feature_report=lambda report, length: [],
        read=lambda length, timeout: [],
        error=lambda: "",
        close=lambda: log("closed"),
    )
"""


class Pad:
    """What the made-up device was sent: its reports, since it was asked last, and how often it was
    closed."""

    def __init__(self, folder):
        folder.mkdir()
        name = "hidraw" if sys.platform.startswith("linux") else "hid"
        (folder / f"{name}.py").write_text(MODULE)
        self.log = folder / "reports"
        self.log.touch()
        sys.modules.pop(name, None)
        sys.path.insert(0, str(folder))
        self.asked = 0

    @property
    def written(self):
        return [bytes.fromhex(line) for line in self.log.read_text().split() if line != "closed"]

    @property
    def closed(self):
        return self.log.read_text().count("closed")

    def is_silent(self):
        return self.written[-2:] == [ZERO, RELEASE]

    def sounds(self):
        """Whether anything was felt since it was asked last."""
        written = self.written
        felt = any(report[3] or report[4] for report in written[self.asked :])
        self.asked = len(written)
        return felt


def steps(window):
    pad = Pad(window.folder / "pad")
    scene = window.module("sample_scenes").build_sample("jackhammer_bench")
    bpy.context.window.scene = scene
    outputs = window.module("addon.live_output.outputs")
    yield from window.show_sidebar()
    bpy.ops.haptic.find_devices()
    yield 1.0
    bpy.ops.haptic.connect_device(device="dualsense")
    yield 1.0
    window.seen["connected"] = outputs.running()["dualsense"].status.state == "open"
    pad.sounds()

    window.point_at_view()
    yield
    yield from window.press("SPACE")
    yield 3.0
    yield from window.screenshot("live-output")
    window.seen["felt while it plays"] = pad.sounds()
    window.point_at_view()
    yield 1.0
    yield from window.press("SPACE")
    yield 0.5
    window.seen["pause is silence"] = pad.is_silent()

    pad.sounds()
    scene.frame_set(scene.frame_current + 20)
    yield 1.0
    window.seen["scrubbing is felt"] = pad.sounds()
    yield from window.press("SPACE")
    yield 2.0
    bpy.ops.ed.undo_push(message="something to undo")
    yield from window.press("SPACE")
    yield from window.undo()
    yield 0.5
    window.seen["undo is silence"] = pad.is_silent()

    window.point_at_view()
    yield
    yield from window.press("SPACE")
    yield 2.0
    window.seen["felt again"] = pad.sounds()
    yield from window.press("BACK_SPACE", ctrl=True, shift=True)
    yield 1.0
    window.seen["panic lets go"] = pad.is_silent() and pad.closed == 1 and not outputs.running()
    yield from window.press("SPACE")

    bpy.ops.haptic.connect_device(device="dualsense")
    yield 1.0
    pad.sounds()
    bpy.ops.wm.read_homefile()
    yield 1.0
    window.seen["another file lets go"] = pad.is_silent() and pad.closed == 2
    yield 0.3
