"""The modalities of a haptic scene file other than vibration, such as warmth."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import asdict
from functools import partial
from pathlib import Path

from ...declaration import Number
from ...forms import Form, JsonObject
from ...modalities import MODALITIES, Modality
from ...modalities.propagation import Emitter, ModalityScene, propagation_function
from ...scene.references import Place, PlacedError, require_known, require_new
from ...scene.values import HapticScene
from ..io.error import errors_in
from .values_json import read_items, read_value


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
    modality = MODALITIES.get(name)
    if modality is None:
        raise PlacedError(
            place, f"there is no modality {name!r}; known are {', '.join(MODALITIES)}"
        )
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
    for i, emitter in enumerate(read_items(form, "sources", partial(read_value, Emitter), place)):
        own = (*place, "sources", i)
        require_known(emitter.object, objects, "object", (*own, "object"))
        require_new(emitter.name, emitters, "source", (*own, "name"))
        _check_quantity(modality.source_value, emitter.value, (*own, "value"))
        emitters[emitter.name] = emitter
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
