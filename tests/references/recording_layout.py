"""A layout that records what a panel draws and refuses what Blender would: unknown properties and
operators."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import bpy


class RecordingLayout:
    """Stands in for UILayout: sub-layouts are the same recorder."""

    operator_context = "INVOKE_DEFAULT"

    def __init__(self) -> None:
        self.labels: list[str] = []
        self.properties: list[str] = []
        self.operators: list[str] = []
        self.operator_icons: list[str] = []
        self.menus: list[str] = []
        self.popovers: list[str] = []
        self.icons: list[int] = []

    def column(self, **_: Any) -> RecordingLayout:
        return self

    row = box = split = grid_flow = column_flow = menu_pie = column

    def context_pointer_set(self, *_: Any) -> None:
        pass

    def separator(self, **_: Any) -> None:
        pass

    def label(self, *, text: str = "", icon: str = "NONE", translate: bool = True) -> None:
        _check_icon(icon)
        self.labels.append(text)

    def prop(self, data: Any, name: str, *, text: str = "", icon: str = "NONE", **_: Any) -> None:
        assert name in data.bl_rna.properties, f"{data.bl_rna.identifier} has no property {name}"
        _check_icon(icon)
        self.properties.append(name)

    def prop_enum(self, data: Any, name: str, value: str, *, text: str = "", **_: Any) -> None:
        assert value in data.bl_rna.properties[name].enum_items, (
            f"{data.bl_rna.identifier}.{name} is never {value}"
        )
        self.properties.append(name)
        self.labels.append(text)

    def prop_search(self, data: Any, name: str, search_data: Any, search: str, **_: Any) -> None:
        assert name in data.bl_rna.properties, f"{data.bl_rna.identifier} has no property {name}"
        assert search in search_data.bl_rna.properties, (
            f"{search_data.bl_rna.identifier} has no property {search}"
        )
        self.properties.append(name)

    def template_list(
        self, kind: str, list_id: str, data: Any, name: str, active_data: Any, active: str, **_: Any
    ) -> None:
        assert hasattr(bpy.types, kind)
        assert name in data.bl_rna.properties
        assert active in active_data.bl_rna.properties

    def template_icon(self, *, icon_value: int, scale: float = 1.0) -> None:
        assert icon_value >= 0
        self.icons.append(icon_value)

    def popover(self, panel: str, **_: Any) -> None:
        assert hasattr(bpy.types, panel)
        self.popovers.append(panel)

    def template_ID(self, data: Any, name: str, **_: Any) -> None:
        assert name in data.bl_rna.properties, f"{data.bl_rna.identifier} has no property {name}"

    def template_curve_mapping(self, data: Any, name: str, **_: Any) -> None:
        assert name in data.bl_rna.properties, f"{data.bl_rna.identifier} has no property {name}"
        self.properties.append(name)

    def progress(self, *, factor: float, text: str = "", **_: Any) -> None:
        assert 0 <= factor <= 1
        self.labels.append(text)

    def operator(self, identifier: str, *, text: str = "", icon: str = "NONE", **_: Any) -> Any:
        _check_icon(icon)
        module, name = identifier.split(".")
        operator = getattr(getattr(bpy.ops, module), name)
        self.operators.append(identifier)
        self.operator_icons.append(icon)
        self.labels.append(text)
        return _OperatorProperties({p.identifier for p in operator.get_rna_type().properties})

    def operator_menu_enum(self, identifier: str, name: str, **values: Any) -> Any:
        properties = self.operator(identifier, **values)
        assert name in properties._names, f"{identifier} has no property {name}"
        return properties

    operator_enum = operator_menu_enum

    def menu(self, identifier: str, **_: Any) -> None:
        assert hasattr(bpy.types, identifier)
        self.menus.append(identifier)


def controls(context: Any) -> list[str]:
    """The buttons and fields of the sidebar's tab: of the headers and of the open panels, as the
    panels draw them."""
    found: list[str] = []
    for panel in bpy.types.Panel.__subclasses__() + [
        kind for base in bpy.types.Panel.__subclasses__() for kind in base.__subclasses__()
    ]:
        if (
            getattr(panel, "bl_category", "") != "Haptics"
            or not hasattr(panel, "bl_rna")
            or not panel.is_registered
            or (getattr(panel, "poll", None) is not None and not panel.poll(context))
        ):
            continue
        layout = RecordingLayout()
        for draw in ("draw_header", "draw_header_preset", "draw"):
            if hasattr(panel, draw) and not (
                draw == "draw" and "DEFAULT_CLOSED" in getattr(panel, "bl_options", ())
            ):
                getattr(panel, draw)(SimpleNamespace(layout=layout), context)
        # Blender draws the switch of a popover's header beside it.
        switches = [
            name for name in layout.popovers if hasattr(getattr(bpy.types, name), "draw_header")
        ]
        found += layout.properties + layout.operators + layout.menus + layout.popovers + switches
    return found


class _OperatorProperties:
    def __init__(self, names: set[str]) -> None:
        object.__setattr__(self, "_names", names)

    def __setattr__(self, name: str, value: Any) -> None:
        assert name in self._names, f"the operator has no property {name}"


def _check_icon(icon: str) -> None:
    assert icon in bpy.types.UILayout.bl_rna.functions["label"].parameters["icon"].enum_items, (
        f"no icon {icon}"
    )
