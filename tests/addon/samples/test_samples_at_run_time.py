"""Every sample: Blender's poses, sent to the server step by step, are answered with Blender's own
levels, silences and impacts."""

import importlib.util
import json
import threading
from pathlib import Path

import pytest
from haptic_tracing.command_line import conformance
from haptic_tracing.command_line.serve.sockets import Door
from websockets.sync.client import connect

CONFORMANCE = Path(__file__).parents[3] / "conformance"
_specification = importlib.util.spec_from_file_location("record", CONFORMANCE / "record.py")
record = importlib.util.module_from_spec(_specification)
_specification.loader.exec_module(record)

PARTS = {
    "air_blast": (1, 50, None, 0),
    "dishwasher_kitchen": (1, 24, None, 0),
    "domino_wall": (1, 62, 16, 14),
    "fireplace": (1, 24, None, 0),
    "hammer_nail": (1, 50, None, 2),
    "jackhammer_bench": (1, 40, None, 5),
    "kart": (1, 46, None, 9),
    "kitchen": (1, 24, None, 0),
    "robot_cell": (1, 46, None, 1),
    "mine_ride": (1, 74, None, 2),
    "pile": (1, 60, 12, 0),
    "rails": (1, 40, None, 0),
    "sliding_and_rolling": (1, 60, None, 0),
}
"""The first frame, at which time is 0 in Blender and at run time, and the last one, the number of things where it can be chosen, and the least number
of impacts. Not of "boardwalk", where bones move the parts of a body: a pose moves an object as a
whole."""
LONGER = {
    "dishwasher_kitchen": (1, 40, None, 0),
    "domino_wall": (1, 100, 16, 14),
    "fireplace": (1, 40, None, 0),
    "hammer_nail": (1, 80, None, 3),
    "jackhammer_bench": (1, 150, None, 5),
    "kart": (1, 90, None, 18),
    "kitchen": (1, 50, None, 0),
    "robot_cell": (1, 60, None, 1),
    "mine_ride": (1, 90, None, 2),
    "sliding_and_rolling": (1, 150, None, 0),
}


@pytest.fixture
def url():
    """The address of a server."""
    with Door(None, None, "127.0.0.1", "", (), lambda conversation: None).listen(0) as server:
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        host, port = server.socket.getsockname()
        yield f"ws://{host}:{port}"
        server.shutdown()
        thread.join()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "part"),
    [*PARTS.items(), *(pytest.param(*item, marks=pytest.mark.more) for item in LONGER.items())],
)
def test_poses_give_what_blender_gives(name, part, build, url):
    """Levels to 0.01 dB, the same impacts, their times to 0.1 ms and their energies to 0.1 %."""
    first, last, count, least = part
    scene = build(name, count)
    document = json.loads(record.written(name, record.recording(scene, first, last)))
    answered = [one["expect"] for one in document["exchange"] if one["send"]["type"] == "step"]
    assert len(answered) == last - first + 1
    assert any(level["level"] is not None for one in answered for level in one["levels"].values())
    assert sum(len(expected["impacts"]) for expected in answered) >= least
    with connect(url) as client:
        assert list(conformance.differences(document, client, None)) == []
