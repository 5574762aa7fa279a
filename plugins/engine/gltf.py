"""Haptics in glTF, through the add-on hooks of Blender's exporter and importer.

The roles of an object are stored in the extras of its node, under `KEY`; contacts with the first of
their two objects, in the axes of the file. Haptic materials can also be written to the MPEG
extension, which can hold kappa and rho only in its extras.
"""

from __future__ import annotations

import copy
from dataclasses import fields
from typing import Any

import bpy
from bpy.types import Object

from ...addon.io.frame_scene import scene_of_frame
from ...addon.io.property_writer import write_body, write_listener, write_source
from ...core.formats.provenance import provenance_of
from ...core.formats.scene.values_json import (
    item_to_dict,
    json_value,
    read_listener,
    read_object,
    read_source,
)
from ...core.forms import Form, JsonObject
from ...core.scene.values import HapticScene, Settings

KEY = "haptic_tracing"
VERSION = 1

origin: Form | None = None
"""The provenance of the haptic scene that is written beside the next file, if there is one."""

_OF_THE_NODE = {"name", "shape", "pose", "motion", "object", "position", "second_position"}
"""Keys that the node itself has, or that have no use there."""


class glTF2ExportUserExtension:
    """Hooks that the exporter instantiates once per file and calls for every node."""

    def __init__(self) -> None:
        scene: Any = bpy.context.scene
        self.properties = scene.haptic_gltf
        self.materials: dict[tuple[str, float, float], int] = {}
        self._forms: dict[str, JsonObject] | None = None
        self._scene: HapticScene | None = None

    def gather_node_hook(self, node: Any, blender_object: Any, export_settings: JsonObject) -> None:
        """Called for every node; ``blender_object`` is None or a collection for some."""
        if not isinstance(blender_object, Object):
            return
        form = self._form(blender_object.name_full, export_settings)
        if form is None:
            return
        if self.properties.use_extras:
            node.extras = {**(node.extras or {}), KEY: {"version": VERSION, **form}}
        if self.properties.use_material and node.mesh is not None and "object" in form:
            node.mesh = self._with_material(node.mesh, form["object"])

    def gather_asset_hook(self, asset: Any, export_settings: JsonObject) -> None:
        """Called for the head of the file: where its haptics come from."""
        self._form("", export_settings)
        if self.properties.use_extras and self._scene is not None:
            asset.extras = {**(asset.extras or {}), KEY: origin or provenance_of(self._scene)}

    def gather_scene_hook(
        self, scene: Any, blender_scene: Any, export_settings: JsonObject
    ) -> None:
        """Called for the scene: the settings."""
        self._form("", export_settings)
        if self.properties.use_extras and self._scene is not None:
            settings = {
                key.name: json_value(getattr(self._scene.settings, key.name))
                for key in fields(Settings)
            }
            scene.extras = {**(scene.extras or {}), KEY: {"version": VERSION, "settings": settings}}

    def gather_gltf_extensions_hook(self, gltf: Any, export_settings: JsonObject) -> None:
        """Called for the whole file: the haptic materials."""
        if not self.materials:
            return
        materials = [
            {"name": name, "extras": {"kappa": kappa, "rho": rho}}
            for name, kappa, rho in self.materials
        ]
        gltf.extensions[self.properties.material_name] = _extension(
            self.properties.material_name, {"materials": materials}
        )

    def _form(self, name: str, export_settings: JsonObject) -> JsonObject | None:
        """The haptic properties of an object; None without a role."""
        if self._forms is None:
            self._forms = {}
            if self.properties.use_extras or self.properties.use_material:
                try:
                    self._scene = scene_of_frame(
                        bpy.context.scene, bpy.context.evaluated_depsgraph_get()
                    )
                # Nothing is tagged, or it can't be traced: a glTF file without haptics.
                except ValueError as error:
                    print(f"Haptic Tracing: no haptics in the glTF file: {error}")
                else:
                    self._forms = forms_of(self._scene, export_settings.get("gltf_yup", True))
        return self._forms.get(name)

    def _with_material(self, mesh: Any, form: JsonObject) -> Any:
        """The mesh with its haptic material; a copy, since objects of different materials may share
        one."""
        material = form.get("material", "") or f"kappa {form['kappa']:g}, rho {form['rho']:g}"
        index = self.materials.setdefault(
            (material, form["kappa"], form["rho"]), len(self.materials)
        )
        name = self.properties.material_name
        mesh = copy.copy(mesh)
        mesh.extensions = {
            **(mesh.extensions or {}),
            name: _extension(name, {"hapticMaterialIndex": index}),
        }
        return mesh


def forms_of(scene: HapticScene, y_up: bool) -> dict[str, JsonObject]:
    """The haptic properties of each object, source and listener, by name."""
    forms: dict[str, JsonObject] = {}
    for role, items in (
        ("object", scene.objects),
        ("source", scene.sources),
        ("listener", scene.listeners),
    ):
        for item in items:
            form = {
                key: value for key, value in item_to_dict(item).items() if key not in _OF_THE_NODE
            }
            forms.setdefault(item.name, {"name": item.name})[role] = form
    for contact in scene.contacts:
        first, second = contact.objects
        form = item_to_dict(contact)
        del form["objects"]
        form["positions"] = [_turned(place, y_up) for place in contact.positions]
        form["normal"] = _turned(contact.normal, y_up)
        forms[first].setdefault("contacts", []).append({"object": second, **form})
    return forms


def _turned(vector: tuple[float, float, float], y_up: bool) -> list[float]:
    x, y, z = vector
    return [x, z, -y] if y_up else [x, y, z]


def _extension(name: str, content: JsonObject) -> Any:
    from io_scene_gltf2.io.com.gltf2_io_extensions import Extension

    return Extension(name=name, extension=content, required=False)


class glTF2ImportUserExtension:
    """Hooks that the importer instantiates once and calls for every node."""

    def gather_import_node_after_hook(
        self, vnode: Any, gltf_node: Any, blender_object: Any, gltf: Any
    ) -> None:
        """Called when an object was made of a node."""
        form = (gltf_node.extras or {}).get(KEY) if isinstance(gltf_node.extras, dict) else None
        if not isinstance(form, dict):
            return
        if KEY in blender_object:
            del blender_object[KEY]  # its content replaces the custom property
        try:
            read_roles(blender_object, form)
        except (ValueError, TypeError, KeyError) as error:
            print(
                f"Haptic Tracing: the haptics of node '{blender_object.name}' are left out: {error}"
            )


def read_roles(obj: Object, form: JsonObject) -> None:
    """Give an object the roles of its node. Raises ValueError, TypeError or KeyError for invalid
    ones."""
    nowhere = {"name": obj.name, "object": obj.name, "position": [0.0, 0.0, 0.0]}
    items: JsonObject = {
        role: make(
            {key: value for key, value in {**base, **form[role]}.items() if key != "second_object"},
            (role,),
        )
        for role, make, base in (
            ("object", read_object, {"name": obj.name}),
            ("source", read_source, nowhere),
            ("listener", read_listener, nowhere),
        )
        if role in form
    }
    if "object" in items:
        write_body(obj.haptics, items["object"])
    if "source" in items:
        write_source(obj.haptics.source, items["source"])
    if "listener" in items:
        write_listener(obj.haptics.listener, items["listener"])
