"""Installs a zip of the extension into a Blender of its own, uses it, disables and removes it. A
program for a bpy wheel.

python installed_extension.py ZIP REPORT.json     with BLENDER_USER_RESOURCES set to an empty
folder; the network is refused
"""

import importlib
import json
import sys
from pathlib import Path


def refuse_network(event: str, _arguments: tuple) -> None:
    if event in {"socket.connect", "socket.getaddrinfo", "socket.sendto"}:
        raise OSError(f"an offline installation asked for the network: {event}")


sys.addaudithook(refuse_network)

import bpy
from registered import difference, registered

MODULE = "bl_ext.user_default.haptic_tracing"


def enable() -> None:
    bpy.ops.preferences.addon_enable(module=MODULE)


def disable() -> None:
    bpy.ops.preferences.addon_disable(module=MODULE)


def wheel_origins() -> dict[str, str]:
    """Where each carried package comes from, imported as the extension imports it."""
    names = ["fcl", "fastjsonschema", "soxr", "hidraw" if sys.platform == "linux" else "hid"]
    return {name: importlib.import_module(name).__file__ for name in names}


def contact_of_two_spheres() -> float:
    """Signed distance of two unit spheres whose centres are 1.5 apart, by the installed narrow
    phase."""
    import fcl
    import numpy

    spheres = [
        fcl.CollisionObject(fcl.Sphere(1.0), fcl.Transform(numpy.array([x, 0.0, 0.0])))
        for x in (0.0, 1.5)
    ]
    request = fcl.CollisionRequest(num_max_contacts=1, enable_contact=True)
    result = fcl.CollisionResult()
    fcl.collide(*spheres, request, result)
    return -result.contacts[0].penetration_depth


def demo(folder: Path) -> dict[str, object]:
    """Builds the demo scene, plays it, and exports its last frame, all with the installed
    extension."""
    samples = importlib.import_module(f"{MODULE}.sample_scenes")
    timeline = importlib.import_module(f"{MODULE}.addon.session.timeline")
    session = importlib.import_module(f"{MODULE}.addon.session.session")
    scene = samples.build_sample("jackhammer_bench")
    bpy.context.window.scene = scene
    blocks = [
        step.result.block
        for step in timeline.steps(scene, scene.frame_start, scene.frame_start + 30)
    ]
    scene.frame_set(scene.frame_start)
    result = session.result_of(scene)
    exported = folder / "demo.json"
    bpy.ops.export_scene.haptic_scene(filepath=str(exported))
    bpy.ops.wm.read_homefile(use_empty=True)
    return {
        "gains": [
            {
                "source": source.name,
                "listener": listener.name,
                "gain": float(result.amplitudes[s, i]),
            }
            for s, source in enumerate(result.sources)
            for i, listener in enumerate(result.listeners)
        ],
        "loudest": max(float(abs(block).max(initial=0.0)) for block in blocks if block is not None),
        "scene": str(exported),
    }


def main(package: str, report: str) -> None:
    found: dict[str, object] = {}
    before = registered()
    answer = bpy.ops.extensions.package_install_files(
        filepath=package, repo="user_default", enable_on_install=True
    )
    found["install"] = sorted(answer)
    found["enabled"] = MODULE in bpy.context.preferences.addons
    found["module"] = importlib.import_module(MODULE).__file__
    found["wheels"] = wheel_origins()
    found["distance"] = contact_of_two_spheres()
    found["demo"] = demo(Path(report).parent)
    working = registered()
    found["adds"] = difference(before, working)

    disable()
    found["left after disabling"] = difference(before, registered())
    for _ in range(3):
        enable()
        bpy.ops.wm.read_homefile(use_empty=True)
        found["changed by enabling again"] = found.get("changed by enabling again") or difference(
            working, registered()
        )
        disable()
        found["left after disabling"] = found["left after disabling"] or difference(
            before, registered()
        )

    module = sys.modules[MODULE]
    for _ in range(3):  # without Blender's own book-keeping around it
        module.register()
        module.unregister()
    found["left after unregistering"] = difference(before, registered())

    enable()
    bpy.ops.extensions.package_uninstall(repo_index=repository_index(), pkg_id="haptic_tracing")
    found["left after uninstalling"] = difference(before, registered())
    found["files left"] = [str(path) for path in Path(found["module"]).parent.glob("*")]
    Path(report).write_text(json.dumps(found, indent=1), encoding="utf-8")


def repository_index() -> int:
    return [repository.module for repository in bpy.context.preferences.extensions.repos].index(
        "user_default"
    )


if __name__ == "__main__":
    main(*sys.argv[1:])
