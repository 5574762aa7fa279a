"""The modalities of a haptic scene file other than vibration, such as warmth."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import asdict
from pathlib import Path

from ...declaration import Number
from ...forms import Form, JsonObject
from ...modalities import MODALITIES, Modality
from ...modalities.propagation import Emitter, ModalityScene, propagation_function
from ...scene.references import Place, PlacedError, require_known
from ...scene.values import HapticScene
from ..io.error import errors_in

CARRIED: Mapping[str, Modality] = {
    name: modality for name, modality in MODALITIES.items() if not modality.sampled
}
"""The modalities that have a section in files."""


def modalities_to_dict(scenes: Iterable[ModalityScene]) -> JsonObject:
    """The JSON objects of the modalities that are not empty."""
    return {
        item.modality.name: _form(item)
        for item in sorted(scenes, key=lambda item: item.modality.name)
        if not item.is_empty
    }


def _form(scene: ModalityScene) -> JsonObject:
    form: JsonObject = {} if scene.enabled else {"enabled": False}
    names = sorted({*scene.values, *scene.forms})
    order = scene.modality.quantities
    form["objects"] = [
        {
            "object": name,
            **({"values": {key: values[key] for key in order if key in values}} if values else {}),
            **({"propagation": dict(scene.forms[name])} if name in scene.forms else {}),
        }
        for name in names
        for values in (scene.values.get(name, {}),)
    ]
    form["sources"] = [asdict(item) for item in scene.emitters]
    return form


def modalities_from_dict(
    document: Form, scene: HapticScene, file: str | Path
) -> tuple[ModalityScene, ...]:
    """The modalities of a validated document. Raises FormatError."""
    objects = {item.name for item in scene.objects}
    with errors_in(file):
        return tuple(
            _read(name, form, objects) for name, form in document.get("modalities", {}).items()
        )


def _read(name: str, form: Form, objects: set[str]) -> ModalityScene:
    place: Place = ("modalities", name)
    modality = CARRIED.get(name)
    if modality is None:
        raise PlacedError(place, f"there is no modality {name!r}; known are {', '.join(CARRIED)}")
    values: dict[str, Mapping[str, float]] = {}
    forms: dict[str, Form] = {}
    for i, item in enumerate(form.get("objects", [])):
        own = (*place, "objects", i)
        called = item["object"]
        require_known(called, objects, "object", (*own, "object"))
        if called in values:
            raise PlacedError((*own, "object"), f"{called!r} occurs twice")
        values[called] = item.get("values", {})
        _check_values(modality, values[called], (*own, "values"))
        if "propagation" in item:
            forms[called] = _function(modality, item["propagation"], (*own, "propagation"))
    emitters: dict[str, Emitter] = {}
    for i, item in enumerate(form.get("sources", [])):
        own = (*place, "sources", i)
        called = item["name"]
        require_known(item["object"], objects, "object", (*own, "object"))
        if called in emitters:
            raise PlacedError((*own, "name"), f"there is a source {called!r} already")
        _check_quantity(modality.source_value, item["value"], (*own, "value"))
        x, y, z = item["position"]
        emitters[called] = Emitter(called, item["object"], (x, y, z), item["value"])
    return ModalityScene(
        modality=modality,
        values={key: given for key, given in values.items() if given},
        forms=forms,
        emitters=tuple(emitters[key] for key in sorted(emitters)),
        enabled=form.get("enabled", True),
    )


def _function(modality: Modality, form: Form, place: Place) -> Form:
    """The JSON object of a function; its parameters must not be values of the object."""
    for key in modality.defaults():
        if key in form:
            raise PlacedError((*place, key), "is a value of the object: it belongs under values")
    try:
        propagation_function(modality, modality.defaults(), form)
    except (ValueError, TypeError) as error:
        raise PlacedError(place, str(error)) from None
    return form


def _check_values(modality: Modality, values: Mapping[str, float], place: Place) -> None:
    known = modality.quantities
    for key, value in values.items():
        if key not in known:
            raise PlacedError((*place, key), f"unknown key; known are {', '.join(known)}")
        _check_quantity(known[key], value, (*place, key))


def _check_quantity(quantity: Number, value: float, place: Place) -> None:
    try:
        quantity.checked(value)
    except ValueError as error:
        raise PlacedError(place, str(error)) from None
