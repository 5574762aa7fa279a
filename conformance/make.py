"""The conformance files: what a run-time server must answer, computed here by closed forms, without
Haptic Tracing.

python conformance/make.py      write them beside this script

Each file is a conversation: messages to send, and what must come back. Levels are in decibels of
full scale (tolerance 0.01 dB), null for silence; impacts have a time (1 ms) and an energy (1 %).
"""

import json
import math
from itertools import pairwise
from pathlib import Path

HERE = Path(__file__).parent
ALPHA = 0.3
"""Loss of the objects [1/m]: their function is exp(-ALPHA d)."""
G = 9.81
RATE = 50
LOSS = {"function": "exponential", "alpha": ALPHA}
STILL = [1, 0, 0, 0]
TONE = {
    "signal": "sine",
    "frequency": 80,
}  # whole periods in the quarter of a second that levels are taken over


def item(name, **more):
    return {"name": name, "kappa": 0.1, "rho": 0.9, "propagation": LOSS, **more}


def box(name, size, place, **more):
    return item(name, shape={"type": "box", "size": size}, pose={"position": place}, **more)


def floor_and_crate(**more):
    """A crate of 1 m on the ground, a tone on the ground 3 m from it, and a hand on top of it."""
    return {
        "objects": [
            box("ground", [20, 20, 1], [0, 0, -0.5], motion="static"),
            box("crate", [1, 1, 1], [0, 0, 0.5], mass=5),
        ],
        "sources": [
            {
                "name": "drill",
                "object": "ground",
                "position": [3, 0, 0],
                "amplitude": 0.5,
                "signal": TONE,
            }
        ],
        "listeners": [
            {"name": "hand", "object": "crate", "position": [0, 0, 1], "gain": 2, "radius": 0}
        ],
        **more,
    }


def level(gain, amplitude=0.5, of_listener=2.0):
    """The level of a tone that arrives with ``gain`` [dB]: RMS of a sine."""
    return 20 * math.log10(gain * amplitude * of_listener / math.sqrt(2))


def hello(scene, **more):
    return {
        "send": {"type": "hello", "version": 1, "scene": scene, **more},
        "expect": {"type": "scene"},
    }


def steps(count, first=0, last=None, **each):
    """Steps at `RATE` a second, of which only the last has expectations."""
    sent = [
        {"send": {"type": "step", "time": round((first + k) / RATE, 9), **each}}
        for k in range(count)
    ]
    if last is not None:
        sent[-1]["expect"] = {"type": "frame", **last}
    return sent


def felt(gain, listener="hand", source="drill", **more):
    """What a listener feels that one tone reaches with ``gain``, 0 for silence."""
    return {
        "levels": {
            listener: {"level": level(gain, **more) if gain else None, "gains": {source: gain}}
        }
    }


def tone():
    bar = {
        "objects": [item("bar")],
        "sources": [
            {
                "name": "drill",
                "object": "bar",
                "position": [0, 0, 0],
                "amplitude": 0.5,
                "signal": TONE,
            }
        ],
        "listeners": [
            {"name": "hand", "object": "bar", "position": [2, 0, 0], "gain": 2, "radius": 0}
        ],
    }
    gain = math.exp(-ALPHA * 2)
    quieter = {"send": {"type": "step", "time": 1.0, "sources": {"drill": {"amplitude": 0.25}}}}
    silent = {"send": {"type": "step", "time": 2.0, "sources": {"drill": {"playing": False}}}}
    return [
        hello(bar),
        *steps(40, last=felt(gain)),
        quieter,
        *steps(20, 51, felt(gain, amplitude=0.25)),
        silent,
        *steps(20, 101, felt(0.0)),
    ]


def chain():
    links = [f"link {k}" for k in range(6)]
    scene = {
        "objects": [item(name) for name in links],
        "contacts": [
            {
                "objects": [a, b],
                "positions": [[k + 1, 0, 0]] * 2,
                "transmission": {"function": "constant", "gain": 0.9},
            }
            for k, (a, b) in enumerate(pairwise(links))
        ],
        "sources": [
            {
                "name": "drill",
                "object": links[0],
                "position": [0, 0, 0],
                "amplitude": 0.5,
                "signal": TONE,
            }
        ],
        "listeners": [
            {"name": "hand", "object": links[-1], "position": [6, 0, 0], "gain": 2, "radius": 0}
        ],
    }
    return [hello(scene), *steps(40, last=felt(math.exp(-ALPHA * 6) * 0.9**5))]


def loop():
    """Two ways round a ring of four: the best path takes the shorter one."""
    corners = {"south": (0, 0), "east": (3, 0), "north": (3, 3), "west": (0, 5)}
    touching = [
        ("south", "east", (2, 0)),
        ("east", "north", (3, 2)),
        ("north", "west", (1, 4)),
        ("west", "south", (0, 2)),
    ]
    scene = {
        "objects": [item(name) for name in corners],
        "contacts": [
            {"objects": [a, b], "positions": [[*place, 0]] * 2} for a, b, place in touching
        ],
        "sources": [
            {
                "name": "drill",
                "object": "south",
                "position": [0, 0, 0],
                "amplitude": 0.5,
                "signal": TONE,
            }
        ],
        "listeners": [
            {"name": "hand", "object": "north", "position": [3, 3, 0], "gain": 2, "radius": 0}
        ],
        "settings": {"strategy": "best_path"},
    }
    south_east = math.dist((0, 0), (2, 0)) + math.dist((2, 0), (3, 2)) + math.dist((3, 2), (3, 3))
    south_west = math.dist((0, 0), (0, 2)) + math.dist((0, 2), (1, 4)) + math.dist((1, 4), (3, 3))
    return [hello(scene), *steps(40, last=felt(math.exp(-ALPHA * min(south_east, south_west))))]


def boxes():
    """A crate on the ground touches it at its middle; lifted, it is silent; moved, it is nearer;
    turned by 90 degrees, its hand moves."""
    turn = [math.sqrt(0.5), 0, 0, math.sqrt(0.5)]
    scene = floor_and_crate(
        listeners=[
            {"name": "hand", "object": "crate", "position": [0.4, 0, 1], "gain": 2, "radius": 0}
        ]
    )

    def at(pose, first, gain):
        return steps(30, first, felt(gain), poses={"crate": pose})

    up = math.hypot(0.4, 1)
    return [
        hello(scene),
        *at([0, 0, 0.5, *STILL], 0, math.exp(-ALPHA * (3 + up))),
        *at([0, 0, 4, *STILL], 100, 0.0),
        *at([1, 0, 0.5, *STILL], 200, math.exp(-ALPHA * (2 + up))),
        *at([1, 0, 0.5, *turn], 300, math.exp(-ALPHA * (2 + up))),
    ]


def fall(height, frame_rate, seconds, convert=lambda x, y, z: [x, y, z, *STILL]):
    """Steps of a crate that falls onto the ground."""
    for k in range(round(seconds * frame_rate)):
        time = k / frame_rate
        yield {
            "send": {
                "type": "step",
                "time": time,
                "poses": {"crate": convert(0, 0, max(height - G / 2 * time**2, 0) + 0.5)},
            }
        }


def with_impact(exchange, height):
    """The exchange with the expectation that one impact comes, in the step in which it happens, and
    none elsewhere."""
    when = math.sqrt(2 * height / G)
    for one in exchange:
        now = one["send"].get("time")
        if now is not None:
            one["expect"] = {"type": "frame", "impacts": []}
            if (
                when <= now
                and when is not None
                and not any(e.get("expect", {}).get("impacts") for e in exchange)
            ):
                one["expect"]["impacts"] = [
                    {
                        "objects": ["ground", "crate"],
                        "time": when,
                        "energy": 5 * G * height,
                        "estimated": False,
                    }
                ]
    return exchange


def impact():
    return with_impact([hello(floor_and_crate()), *fall(1.5, 60, 0.9)], 1.5)


def axes_of_unity():
    """The fall again, in left-handed axes with y up."""
    scene = hello(floor_and_crate(), up="y", handedness="left")
    return with_impact([scene, *fall(1.5, 60, 0.9, lambda x, y, z: [x, z, y, *STILL])], 1.5)


def set_down():
    """A crate that something else than physics carries comes down at 1.5 m/s to the ground, and
    stays there: poses do not tell whether it braked before, so its blow is estimated."""
    scene = floor_and_crate(sources=[])
    scene["objects"][1]["motion"] = "kinematic"
    height, speed = 0.5, 1.5
    exchange = [hello(scene)]
    for k in range(30):
        time = k / RATE
        blow = {
            "time": height / speed,
            "objects": ["ground", "crate"],
            "energy": 5 / 2 * speed**2,
            "estimated": True,
        }
        struck = 0 <= time - height / speed < 1 / RATE
        expected = {"type": "frame", "impacts": [blow] if struck else []}
        sent = _at(time, max(height - speed * time, 0.0) + 0.5)
        exchange.append({"send": sent, "expect": expected})
    return exchange


def slide():
    """A crate slides over ridges of 12.5 mm at half a metre per second: a tone of 40 Hz where it
    touches, whose amplitude follows from its weight and speed. At rest it is silent."""
    speed, mass = 0.5, 5
    texture = {"period": 0.0125, "sliding": 0.5, "noise": 0, "full_force": 100, "full_speed": 1}
    scene = floor_and_crate(sources=[], rules={"textures": [texture]})
    at = [{"crate": [speed * k / RATE, 0, 0.5, *STILL]} for k in range(50)]
    amplitude = 0.5 * math.sqrt(mass * G / 100) * speed**0.75
    tone = {"levels": {"hand": {"level": level(math.exp(-ALPHA), amplitude)}}}
    sliding = [one for k, pose in enumerate(at) for one in steps(1, k, poses=pose)]
    sliding[-1]["expect"] = {"type": "frame", **tone}
    silence = {"levels": {"hand": {"level": None}}}
    return [hello(scene), *sliding, *steps(20, 50, silence)]


def impact_of_the_engine():
    """An impact that the engine reports, with half the energy that gives the full amplitude (100
    J)."""
    gain = math.exp(-ALPHA * 1)
    hit = {"objects": ["ground", "crate"], "position": [0, 0, 0], "time": 0.61, "energy": 50}
    slow = {"objects": ["ground", "crate"], "position": [0, 0, 0], "time": 0.63, "normal_speed": 4}
    expected = [
        {
            "objects": ["ground", "crate"],
            "time": 0.61,
            "energy": 50,
            "amplitude": 0.5,
            "estimated": False,
            "gains": {"hand": gain},
        }
    ]
    return [
        hello(floor_and_crate(sources=[], rules={"least_energy": 5, "full_energy": 100})),
        *steps(31),
        {
            "send": {"type": "step", "time": 0.62, "impacts": [hit]},
            "expect": {"type": "frame", "impacts": expected},
        },
        {
            "send": {"type": "step", "time": 0.64, "impacts": [slow]},
            "expect": {"type": "frame", "impacts": [{"energy": 5 * 4**2 / 2}]},
        },
        {
            "send": {"type": "step", "time": 0.66, "impacts": []},
            "expect": {"type": "frame", "impacts": []},
        },
    ]


def spawn_and_removal():
    """A second crate on the first; without the first, which held it, nothing arrives."""
    upper = box("upper", [1, 1, 1], [0, 0, 1.5], mass=1)
    foot = {"name": "foot", "object": "upper", "position": [0, 0, 2], "radius": 0, "gain": 2}
    names = {"objects": ["ground", "crate", "upper"], "listeners": ["hand", "foot"]}
    return [
        hello(floor_and_crate()),
        *steps(1),
        {
            "send": {"type": "add", "object": upper, "listener": foot},
            "expect": {"type": "scene", **names},
        },
        *steps(30, 1, felt(math.exp(-ALPHA * 5), "foot")),
        {
            "send": {"type": "remove", "object": "crate"},
            "expect": {"type": "scene", "objects": ["ground", "upper"], "listeners": ["foot"]},
        },
        *steps(30, 31, felt(0.0, "foot")),
    ]


def others_come_and_go():
    """The fall again, while another crate comes, far away, or one goes, before each step."""
    falling = list(fall(1.5, 60, 0.9))
    exchange = [hello(floor_and_crate())]
    for number, step in enumerate(falling):
        other = box(f"other {number // 2}", [1, 1, 1], [100 + number, 0, 9], mass=5)
        come = {"type": "add", "object": other}
        go = {"type": "remove", "object": f"other {number // 2}"}
        exchange += [{"send": go if number % 2 else come}, step]
    return with_impact(exchange, 1.5)


def set_elsewhere():
    """A crate 5 m above the ground is on it in the next step, and above it again: it has hit
    nothing."""
    high, low = ({"crate": [0, 0, z, *STILL]} for z in (5.5, 0.5))
    none = {"impacts": []}
    return [
        hello(floor_and_crate()),
        *steps(5, poses=high),
        *steps(1, 5, none, poses=low),
        *steps(1, 6, none, poses=low),
        *steps(1, 7, none, poses=high),
        *steps(1, 8, none, poses=high),
    ]


def one_shot():
    """A source with triggers is silent until it is played, and after it."""
    click = {"name": "click", "object": "crate", "position": [0, 0, 1], "triggers": []}
    return [
        hello(floor_and_crate(sources=[click])),
        *steps(20, last={"levels": {"hand": {"level": None}}}),
        {"send": {"type": "play", "source": "click"}},
        *steps(1, 20, {"levels": {"hand": {"felt": True}}}),
        *steps(100, 21, {"levels": {"hand": {"level": None}}}),
    ]


def back_in_time():
    """A step back begins anew: the crate, now on the ground, makes no impact."""
    falling = list(fall(1.5, 60, 0.5))
    landed = {
        "send": {"type": "step", "time": 0.1, "poses": {"crate": [0, 0, 0.5, *STILL]}},
        "expect": {"type": "frame", "impacts": [], "n": 0},
    }
    return [hello(floor_and_crate()), *falling, landed]


def flooding():
    """An engine that sends by its clock: 240 steps at once, in which a crate falls once and is
    lifted. Each is answered or named, and the blow arrives, once."""
    return [hello(floor_and_crate()), _flood(0.0)]


def slow_client():
    """An engine that reads nothing for a second: nothing is lost with the frames that it missed."""
    return [hello(floor_and_crate()), _flood(1.0)]


def _flood(pause):
    """Steps for 4 s at 60 a second, with a fall of 1 m that begins at 1 s."""
    messages, height = [], 1.0
    for k in range(240):
        time = k / 60
        fallen = G / 2 * max(time - 1, 0.0) ** 2
        z = 0.5 + max(height - fallen, 0.0) + max(time - 3, 0.0)
        step = {"type": "step", "id": k, "time": time, "poses": {"crate": [0, 0, z, *STILL]}}
        messages.append(step)
    blow = {
        "time": 1 + math.sqrt(2 * height / G),
        "objects": ["ground", "crate"],
        "energy": 5 * G * height,
    }
    expected = {
        "type": "frame",
        "id": 239,
        "answers": list(range(240)),
        "impacts": [blow],
        "n": math.floor(239 / 60 * 8000 + 0.5),
        "levels": {"hand": {"gains": {"drill": 0.0}}},
    }
    return {"send": messages, "pause": pause, "expect": expected}


def hitching():
    """A crate that comes down at 1.5 m/s, and an engine that stands still: over 0.2 s a blow has
    the mean speed between both poses, 3.5 m/s here; over more than 0.25 s nothing strikes."""
    exchange = [hello(floor_and_crate(sources=[]))]
    speed, pause = 1.5, 0.2
    for begun, gap, struck in ((0.0, 0.2, True), (10.0, 0.26, False)):
        exchange += [
            {"send": _at(begun + k / RATE, 1.5 - speed * k / RATE)}
            for k in range(round(pause * RATE) + 1)
        ]
        way = 1.0 - speed * pause
        blow = {
            "time": begun + pause + gap,
            "objects": ["ground", "crate"],
            "energy": 5 / 2 * (way / gap) ** 2,
        }
        expected = {"type": "frame", "impacts": [blow] if struck else []}
        exchange.append({"send": _at(begun + pause + gap, 0.5), "expect": expected})
    return exchange


def _at(time, height):
    return {"type": "step", "time": time, "poses": {"crate": [0, 0, height, *STILL]}}


def mixed():
    """Objects with and without shapes in one scene: what the engine reports of both, listed
    contacts, a body that loses its shape, and clocks that show Unix time."""
    post = item("post", pose={"position": [9, 0, 0]})
    crate = box("crate", [1, 1, 1], [0, 0, 0.5], mass=5)
    contact = {
        "objects": ["post", "ground"],
        "positions": [[9, 0, 0]] * 2,
        "transmission": {"function": "constant", "gain": 0.5},
    }
    scene = floor_and_crate(
        contacts=[contact],
        listeners=[
            {"name": "hand", "object": "post", "position": [9, 0, 1], "gain": 2, "radius": 0}
        ],
    )
    scene["objects"].insert(0, post)
    gain = math.exp(-ALPHA * (6 + 1)) * 0.5
    now = 1.7e9
    hit = {"objects": ["crate", "post"], "position": [9, 0, 3], "energy": 50.0, "time": now + 2}
    felt_blow = {
        "objects": ["crate", "post"],
        "energy": 50.0,
        "gains": {"hand": math.exp(-ALPHA * 2)},
    }
    shapeless = {key: value for key, value in crate.items() if key not in ("shape", "pose")}
    return [
        hello(scene),
        *[{"send": {"type": "step", "time": now + k / 64}} for k in range(60)],
        {
            "send": {"type": "step", "time": now + 60 / 64},
            "expect": {"type": "frame", **felt(gain)},
        },
        {
            "send": {"type": "step", "time": now + 61 / 64, "impacts": [hit]},
            "expect": {"type": "frame", "impacts": [felt_blow]},
        },
        {"send": {"type": "replace", "object": shapeless}, "expect": {"type": "scene"}},
        {
            "send": {"type": "step", "time": now + 62 / 64},
            "expect": {
                "type": "frame",
                "levels": {"hand": {"gains": {"drill": gain}}},
                "impacts": [],
            },
        },
    ]


def mistakes():
    def wrong(message, where):
        return {"send": message, "expect": {"type": "error", "where": where}}

    return [
        wrong({"type": "hello", "version": 7}, "/version"),
        hello(floor_and_crate()),
        wrong({"type": "dance"}, "/type"),
        wrong({"type": "step"}, "/time"),
        wrong({"type": "step", "time": 0, "poses": {"moon": [0, 0, 0, *STILL]}}, "/poses/moon"),
        wrong(
            {"type": "step", "time": 0, "poses": {"crate": [0, 0, 0, 0, 0, 0, 0]}}, "/poses/crate"
        ),
        wrong({"type": "remove", "source": "moon"}, "/source"),
        *steps(30, last=felt(math.exp(-ALPHA * 4))),
        {"send": {"type": "stop"}, "expect": {"type": "stopped"}},
    ]


FILES = (
    tone,
    chain,
    loop,
    boxes,
    impact,
    set_down,
    axes_of_unity,
    impact_of_the_engine,
    slide,
    spawn_and_removal,
    others_come_and_go,
    set_elsewhere,
    one_shot,
    back_in_time,
    flooding,
    slow_client,
    hitching,
    mixed,
    mistakes,
)


def written():
    """The files' names and texts."""
    for make in FILES:
        title = " ".join((make.__doc__ or make.__name__).split())
        lines = ",\n  ".join(json.dumps(one) for one in make())
        yield (
            f"{make.__name__}.json",
            f'{{"title": {json.dumps(title)},\n "exchange": [\n  {lines}\n ]}}\n',
        )


if __name__ == "__main__":
    for name, text in written():
        (HERE / name).write_text(text)
        print(f"wrote {name}")
