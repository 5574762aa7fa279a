"""``haptic-tracing fit``: the loss of one object and one contact from two recordings of an event,
at its source and at a listener."""

from __future__ import annotations

import argparse
from dataclasses import replace

from ..core.design.recordings import Question, fit, read_recordings
from ..core.formats.scene.scene_json import write_scene
from ..core.forms import JsonObject
from ..core.message import sentence
from ..core.run_time import load
from ..core.scene.coefficients import coefficients_of
from ..core.scene.functions import Constant
from . import print_json, say, warn_of_unknown
from .standard_streams import DASH, for_output, put_out


def run(args: argparse.Namespace) -> int:
    """Read scene and recordings, fit, print, and write the scene with the fitted values."""
    read = load(args.scene)
    warn_of_unknown(args.scene, read.export.unknown)
    scene = read.with_contacts()
    recordings = read_recordings(args.recorded_source, args.recorded_listener)
    for _ in recordings.steps():
        pass
    measured = recordings.transfer()
    asked = Question(
        args.source, args.listener, (args.object,), tuple(args.contact or ()), not args.uncalibrated
    )
    found = fit(read.graph(), measured, asked)
    kappa, rho = coefficients_of(
        found.k, next(item.rho for item in scene.objects if item.name == args.object)
    )
    printed: JsonObject = {
        "object": {
            "name": args.object,
            "damping": found.damping,
            "standard_deviation": found.damping_error,
            "kappa": kappa,
            "rho": rho,
        },
        "difference_before": found.before,
        "difference_after": found.after,
        "coherent_part": float(measured.used.mean()),
        "not_determined": [sentence(doubt) for doubt in found.doubts],
    }
    if asked.contact:
        printed["contact"] = {
            "objects": list(asked.contact),
            "gain": found.gain,
            "standard_deviation": found.contact_error,
        }
    if args.out != DASH:
        print_json(printed, args.stdout)
    if args.out is not None:
        objects = tuple(
            replace(o, kappa=kappa, rho=rho) if o.name == args.object else o for o in scene.objects
        )
        contacts = tuple(
            replace(c, transmission=Constant(gain_value=found.gain))
            if set(c.objects) == set(asked.contact)
            else c
            for c in scene.contacts
        )
        new = for_output(args.out, ".json")
        write_scene(replace(scene, objects=objects, contacts=contacts), new)
        if args.out == DASH:
            put_out([new], args.stdout)
        else:
            say([f"wrote {args.out}"])
    return 0
