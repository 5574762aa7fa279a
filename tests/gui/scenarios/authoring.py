"""Every authoring operator on the default cube and a neighbour, each undone and redone; the German
interface; the gain as a picture."""

import json

import bpy


def state() -> str:
    """Everything that authoring changes."""
    haptics = bpy.context.scene.haptics
    objects = {}
    for obj in bpy.context.scene.objects:
        own = obj.haptics
        objects[obj.name] = (
            own.enabled, own.material.name, round(own.kappa, 4), round(own.rho, 4), own.source.enabled, own.source.signal,
            own.listener.enabled, own.listener.body_part, obj.rigid_body is not None,
            [round(value, 3) for value in obj.matrix_world.translation], obj.select_get(),
        )  # fmt: skip
    library = [(item.name, round(item.kappa, 4)) for item in haptics.materials.items]
    return json.dumps(
        [bpy.context.scene.name, objects, library, haptics.tracing, haptics.mode], sort_keys=True
    )


def steps(window):
    yield from window.show_sidebar()
    with window.context():
        bpy.ops.mesh.primitive_cube_add(location=(2, 0, 0))
        bpy.context.object.name = "Oak Crate"
        bpy.ops.object.select_all(action="SELECT")
    yield 0.3

    def alone(name):
        for obj in bpy.context.scene.objects:
            obj.select_set(obj.name == name)
        bpy.context.view_layer.objects.active = bpy.context.scene.objects[name]

    for number, (operator, arguments, active) in enumerate(
        (
            ("make_objects", {}, None),
            ("make_objects", {"physics": True}, None),
            ("apply_material", {"preset": "rubber"}, None),
            ("new_material", {}, "Oak Crate"),
            ("remove_material", {}, "Oak Crate"),
            ("guess_material", {}, "Oak Crate"),
            ("add_source", {}, "Cube"),
            ("add_listener", {}, "Oak Crate"),
            ("add_default_listeners", {"parts": "ALL"}, "Oak Crate"),
            ("add_source_object", {"kind": "NOISE"}, "Cube"),
            ("add_medium", {}, "Cube"),
            ("select_object", {"name": "Oak Crate"}, "Cube"),
            ("graph_to_geometry", {}, "Cube"),
            ("clear", {}, "Cube"),
            ("add_sample", {"sample": "hammer_nail"}, "Cube"),
        )
    ):
        if active is not None:
            alone(active)
        with window.context():
            bpy.ops.ed.undo_push(message="before")
        yield 0.2
        before = state()
        with window.context():
            getattr(bpy.ops.haptic, operator)("EXEC_DEFAULT", True, **arguments)
        yield 0.2
        after = state()
        yield from window.undo()
        window.seen[f"{number} {operator} is undone"] = state() == before != after
        yield from window.redo()
        window.seen[f"{number} {operator} is redone"] = state() == after

    bpy.context.window.scene = next(
        scene for scene in bpy.data.scenes if "Oak Crate" in scene.objects
    )
    alone("Oak Crate")
    with window.context():
        bpy.ops.haptic.apply_material(preset="stone")
    yield 0.5
    yield from window.screenshot("gain")
    preferences = bpy.context.preferences.view
    languages = [item.identifier for item in preferences.bl_rna.properties["language"].enum_items]
    if "de_DE" in languages or "de" in languages or len(languages) > 1:
        preferences.language = "de_DE"
        preferences.use_translate_interface = True
        yield 0.5
        window.seen["in German"] = (
            bpy.app.translations.pgettext_iface("Make Haptic") == "Haptisch machen"
        )
        words = {
            "Level": "Pegel",
            "Margin": "Abstand",
            "Volume": "Lautstärke",
            "Floor": "Untergrenze",
        }
        for word, german in words.items():  # Blender translates them in another sense
            window.seen[german] = bpy.app.translations.pgettext_iface(word, "Haptics") == german
        yield from window.screenshot("german")
        preferences.language = "en_US"
    yield 0.3
