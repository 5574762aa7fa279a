"""mypy plugin that adds the registered properties of this extension to the stubs of Blender
(fake-bpy-module).

- A property is an annotation that holds a call, ``amplitude: FloatProperty(...)`` or that of a
  function declared to return one. Its type is that of its values.
- A group that `holding` a class of the core decorates has members for its fields.
- Node groups, objects and scenes have `haptics`, as ``addon/registration/properties.py`` says.
- The stubs declare most members as optional. `NEVER_NONE` exist whenever the extension runs, the
  context's object if `poll` checks it.
- Members with too narrow types in the stubs have any type, or that of text.
"""

import ast
from collections.abc import Callable
from functools import cache
from pathlib import Path

from mypy.checker import TypeChecker
from mypy.nodes import (
    MDEF,
    AssignmentStmt,
    CallExpr,
    Decorator,
    FuncDef,
    MypyFile,
    NameExpr,
    StrExpr,
    SymbolTableNode,
    TypeInfo,
    Var,
)
from mypy.plugin import (
    AnalyzeTypeContext,
    AttributeContext,
    ClassDefContext,
    FunctionContext,
    Plugin,
)
from mypy.types import (
    AnyType,
    CallableType,
    Instance,
    NoneType,
    Type,
    TypeOfAny,
    UnboundType,
    UnionType,
    get_proper_type,
)
from mypy.types_utils import remove_optional

ADDON, PLUGINS = "haptic_tracing.addon", "haptic_tracing.plugins"
HAPTICS = {
    "NodeTree": f"{ADDON}.properties.drawing.HapticDrawing",
    "Object": f"{ADDON}.properties.object.HapticObjectProperties",
    "Scene": f"{ADDON}.properties.scene.HapticSceneProperties",
}
"""The property group in `haptics`, by the type of Blender that has it."""
VALUES = {
    "BoolProperty": "bool",
    "EnumProperty": "str",
    "FloatProperty": "float",
    "IntProperty": "int",
    "StringProperty": "str",
}
"""The type of a property's values, by the function that defines the property."""
NEVER_NONE = {
    *(
        f"Context.{name}"
        for name in (
            "scene",
            "view_layer",
            "window_manager",
            "preferences",
            "collection",
            "selected_objects",
            "workspace",
        )
    ),
    *(
        f"Context.{name}" for name in ("area", "region", "region_data")
    ),  # used where the extension draws
    *(
        f"{owner}.layout"
        for owner in ("Header", "Menu", "Operator", "Panel", "UIPopover", "UIPopupMenu")
    ),
    *(
        "Depsgraph.scene",
        "Depsgraph.view_layer",
        "KeyMapItem.properties",
        "Scene.view_settings",
        "ViewLayer.depsgraph",
        "Window.screen",
    ),
    *(
        "Material.node_tree",
        "World.node_tree",
        "RigidBodyWorld.collection",
        "RigidBodyWorld.constraints",
        "RigidBodyWorld.point_cache",
    ),
    "FCurve.driver",  # asked of the curves in `AnimData.drivers`
}
VARYING = {
    *(
        "AreaSpaces.active",
        "Context.space_data",
        "Object.data",
        "Object.pose",
        "bpy_struct.id_data",
    ),
    *(
        "ColorManagedViewSettings.look",
        "ColorManagedViewSettings.view_transform",
        "RenderSettings.engine",
        "Scene.cycles",
    ),
    *("Keyframe.interpolation", "Object.empty_display_type"),
}
"""Members of any type: what they are depends on what they belong to, on Blender's version or other
extensions; or a text is assigned."""
DERIVED = {
    "Attribute",
    "Constraint",
    "Curve",
    "Gizmo",
    "Light",
    "Node",
    "NodeSocket",
    "Property",
    "Space",
}
"""Types of which Blender returns derived ones, with more members."""
UNFINISHED = {"ContextTempOverride", "bpy_prop_array"}
"""Types of which the stubs do not say that ``with`` enters them, or that tuples can be assigned to
them."""
TEXTS = {
    "EventTypeItems",
    "IconItems",
    "OperatorReturnItems",
    "OperatorTypeFlagItems",
    "RegionTypeItems",
    "SpaceTypeItems",
    "WmReportItems",
}
"""Enumerations whose items are passed on as text."""
CALLED_BACK = {"FileHandler", "GizmoGroup", "Header", "Menu", "Operator", "Panel", "UIList"}
"""Types whose methods get a context and an event."""


class BlenderTypes(Plugin):
    """The types of Blender with this extension registered."""

    def get_additional_deps(self, file: MypyFile) -> list[tuple[int, str, int]]:
        """The property groups, for modules that reach them by `haptics` alone."""
        if not file.fullname.startswith("haptic_tracing.") or file.fullname.startswith(
            f"{ADDON}.properties"
        ):
            return []
        is_user = Path(file.path).is_file() and ".haptics" in Path(file.path).read_text("utf-8")
        return [(10, group.rpartition(".")[0], -1) for group in HAPTICS.values()] if is_user else []

    def get_customize_class_mro_hook(
        self, fullname: str
    ) -> Callable[[ClassDefContext], None] | None:
        """What changes a class before its body is analyzed."""
        module, _, name = fullname.rpartition(".")
        if module.startswith((ADDON, PLUGINS)):
            return _write_types
        if fullname == "bpy_extras.io_utils.ExportHelper" or (
            module == "bpy.types" and name in DERIVED
        ):
            return _allow_more
        if module != "bpy.types":
            return None
        if name.startswith("bpy_prop_collection"):
            return _return_items
        return _add_haptics if name in HAPTICS else _pass_context if name in CALLED_BACK else None

    def get_class_decorator_hook_2(self, fullname: str) -> Callable[[ClassDefContext], bool] | None:
        """What changes a class after its body is analyzed."""
        return _add_declared if fullname == f"{ADDON}.properties.declared.holding" else None

    def get_type_analyze_hook(self, fullname: str) -> Callable[[AnalyzeTypeContext], Type] | None:
        """What a name means in an annotation."""
        module, _, name = fullname.rpartition(".")
        if module == "bpy.props" and name.endswith("Property"):
            return _value_type
        if module == "bpy.types" and name in UNFINISHED:
            return lambda context: AnyType(TypeOfAny.explicit)
        if module == "bpy.stub_internal.rna_enums" and name in TEXTS:
            return lambda context: context.api.named_type("builtins.str", [])
        return None

    def get_function_hook(self, fullname: str) -> Callable[[FunctionContext], Type] | None:
        """Return the type of a property's values for a call that defines it, so that functions may
        be declared to return that."""
        module, _, name = fullname.rpartition(".")
        if module != "bpy.props" or not name.endswith("Property"):
            return None
        if name not in VALUES:
            return lambda context: AnyType(TypeOfAny.explicit)
        return lambda context: context.api.named_generic_type(f"builtins.{VALUES[name]}", [])

    def get_attribute_hook(self, fullname: str) -> Callable[[AttributeContext], Type] | None:
        """The type of a member, by its name with that of the class that has it."""
        module, _, member = fullname.partition(".types.")
        owner, _, name = member.partition(".")
        if module != "bpy":
            return None
        if name == "haptics":
            return lambda context: self._group(HAPTICS[owner], context)
        if member in VARYING:
            return lambda context: AnyType(TypeOfAny.explicit)
        if member in NEVER_NONE:
            return lambda context: remove_optional(context.default_attr_type)
        return _polled if member in {"Context.object", "Context.active_object"} else None

    def _group(self, fullname: str, context: AttributeContext) -> Type:
        found = self.lookup_fully_qualified(fullname)
        return (
            Instance(found.node, [])
            if found is not None and isinstance(found.node, TypeInfo)
            else context.default_attr_type
        )


def _polled(context: AttributeContext) -> Type:
    """The type of the context's object: not None in methods of a class whose own `poll` has asked
    for it."""
    assert isinstance(context.api, TypeChecker)
    info, method = context.api.scope.current_class(), context.api.scope.top_level_function()
    poll = (
        info.get("poll")
        if info is not None and method is not None and method.name != "poll"
        else None
    )
    is_asked = (
        poll is not None and poll.node is not None and not poll.node.fullname.startswith("bpy.")
    )
    return remove_optional(context.default_attr_type) if is_asked else context.default_attr_type


def _return_items(context: ClassDefContext) -> None:
    """Let `get` of a collection return its items, not only the default."""
    for statement in context.cls.defs.body:
        if (
            isinstance(statement, FuncDef)
            and statement.name == "get"
            and isinstance(statement.type, CallableType)
        ):
            statement.type.ret_type = UnionType(
                [UnboundType(context.cls.type_vars[0].name), statement.type.ret_type]
            )


def _allow_more(context: ClassDefContext) -> None:
    """Let objects of a class have members that the class has not."""
    context.cls.info.fallback_to_any = True


def _add_haptics(context: ClassDefContext) -> None:
    """Give a class the member; `get_attribute_hook` gives it its type."""
    variable = Var("haptics", AnyType(TypeOfAny.explicit))
    variable.info = context.cls.info
    variable._fullname = f"{context.cls.fullname}.haptics"
    context.cls.info.names["haptics"] = SymbolTableNode(MDEF, variable, plugin_generated=True)


def _pass_context(context: ClassDefContext) -> None:
    """Let the methods that Blender calls get a context and an event, never None."""
    for statement in context.cls.defs.body:
        method = statement.func if isinstance(statement, Decorator) else statement
        if isinstance(method, FuncDef) and isinstance(method.type, CallableType):
            arguments = zip(method.type.arg_names, method.type.arg_types, strict=True)
            method.type.arg_types = [
                _some(kind) if name in {"context", "event"} else kind for name, kind in arguments
            ]


def _some(kind: Type) -> Type:
    """A type that is not analyzed yet, without its None."""
    if not isinstance(kind, UnionType):
        return kind
    return UnionType(
        [
            _some(item)
            for item in kind.items
            if not (isinstance(item, UnboundType) and item.name == "None")
        ],
        kind.line,
    )


def _add_declared(context: ClassDefContext) -> bool:
    """Give a property group members for the fields of the class that it holds, by the names that
    the decorator says."""
    call, group = context.reason, context.cls.info
    assert (
        isinstance(call, CallExpr)
        and isinstance(call.args[0], NameExpr)
        and isinstance(call.args[0].node, TypeInfo)
    )
    names = {
        key: value.value
        for key, value in zip(call.arg_names, call.args, strict=True)
        if isinstance(value, StrExpr)
    }
    for name, symbol in call.args[0].node.names.items():
        if isinstance(symbol.node, Var) and names.get(name, name) not in group.names:
            if symbol.node.type is None:
                return False
            variable = Var(names.get(name, name), _held(symbol.node.type, context))
            variable.info = group
            group.names[variable.name] = SymbolTableNode(MDEF, variable, plugin_generated=True)
    return True


def _held(kind: Type, context: ClassDefContext) -> Type:
    """The type of the values of a property that holds those of a field."""
    kind = get_proper_type(remove_optional(kind))
    if isinstance(kind, Instance) and kind.type.has_base("builtins.str"):
        return context.api.named_type("builtins.str")
    return (
        kind
        if isinstance(kind, Instance) and kind.type.module_name == "builtins"
        else AnyType(TypeOfAny.explicit)
    )


def _write_types(context: ClassDefContext) -> None:
    """Write the calls in the annotations of a class as types."""
    calls = _calls(context.api.modules[context.cls.info.module_name].path)
    for statement in context.cls.defs.body:
        if isinstance(statement, AssignmentStmt) and isinstance(statement.lvalues[0], NameExpr):
            call = calls.get((statement.line, statement.lvalues[0].name))
            if call is not None:
                statement.unanalyzed_type = statement.type = _written(call, context)


@cache
def _calls(path: str) -> dict[tuple[int, str], ast.Call]:
    """The calls in annotations of a module, by line and name."""
    nodes = [
        node
        for node in ast.walk(ast.parse(Path(path).read_text("utf-8")))
        if isinstance(node, ast.AnnAssign)
    ]
    return {
        (node.lineno, ast.unparse(node.target)): node.annotation
        for node in nodes
        if isinstance(node.annotation, ast.Call)
    }


def _written(call: ast.Call, context: ClassDefContext) -> Type:
    """A call as a type: ``PointerProperty(type=Object)`` as ``PointerProperty[Object]``, else what
    the function is declared to return."""
    name = ast.unparse(call.func)
    found = context.api.lookup_qualified(name, context.cls)
    if (
        found is None
        or not isinstance(found.node, FuncDef)
        or not isinstance(found.node.type, CallableType)
    ):
        return AnyType(TypeOfAny.explicit)
    if found.node.fullname.startswith("bpy.props."):
        kinds = [ast.unparse(keyword.value) for keyword in call.keywords if keyword.arg == "type"]
        groups = [context.api.lookup_qualified(kind, context.cls) for kind in kinds]
        # Made at run time.
        is_made = any(group is not None and isinstance(group.node, Var) for group in groups)
        return UnboundType(name, [] if is_made else [UnboundType(kind) for kind in kinds])
    returned = found.node.type.ret_type
    if isinstance(returned, UnboundType) and returned.name in VALUES:
        return context.api.named_type(f"builtins.{VALUES[returned.name]}")
    is_readable = (
        not isinstance(returned, UnboundType)
        or found.node.fullname.rpartition(".")[0] == context.cls.info.module_name
    )
    return returned if is_readable else AnyType(TypeOfAny.explicit)


def _value_type(context: AnalyzeTypeContext) -> Type:
    """The type of a property's values: ``FloatProperty`` is float, ``PointerProperty[Object]`` an
    object or None."""
    name = context.type.name.rpartition(".")[2]
    kinds: list[Type] = [
        get_proper_type(context.api.analyze_type(kind)) for kind in context.type.args
    ]
    if name in VALUES:
        return context.api.named_type(f"builtins.{VALUES[name]}", [])
    if name == "CollectionProperty" and kinds:
        return context.api.named_type("bpy.types.bpy_prop_collection_idprop", kinds)
    if name == "PointerProperty" and kinds and isinstance(kinds[0], Instance):
        is_id = any(base.fullname == "bpy.types.ID" for base in kinds[0].type.mro)
        return UnionType([kinds[0], NoneType()]) if is_id else kinds[0]
    return AnyType(TypeOfAny.explicit)


def plugin(version: str) -> type[Plugin]:
    """The entry point that mypy calls with its version."""
    return BlenderTypes
