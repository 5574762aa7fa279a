"""Plays a scenario in Blender's own window: real events, one step at a time, with screenshots. Runs
inside Blender:

blender --enable-event-simulate --python window.py -- SCENARIO.py FOLDER

A scenario is a module with ``steps(window)``, a generator: each ``yield`` hands control back to
Blender, which handles events and redraws until the next step (``yield 2.0`` waits for two seconds).
The outcome goes to FOLDER/report.json, pictures beside it; then Blender quits.
"""

import json
import os
import shutil
import subprocess
import sys
import time
import traceback
from collections.abc import Callable, Generator, Iterator
from importlib import import_module
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from types import ModuleType

import bpy

sys.path.insert(0, str(Path(__file__).parent))

from registered import difference, registered

EXTENSION = "bl_ext.user_default.haptic_tracing"
PAUSE = 0.1  # seconds: some turns of Blender's event loop
KEYS = {"0": "ZERO", "1": "ONE", "2": "TWO", "3": "THREE", "4": "FOUR"}
KEYS |= {"5": "FIVE", "6": "SIX", "7": "SEVEN", "8": "EIGHT", "9": "NINE", ".": "PERIOD"}
Steps = Iterator[float | None]


class Window:
    """Blender's window as a scenario uses it. Places are pixels from the lower left corner."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.seen: dict[str, object] = {}  # what a scenario found, for the report
        self.mouse = (0, 0)
        self.clicks = 0  # of the left mouse button
        self.is_in_properties = False  # whether panels are looked for there or in the sidebar

    @property
    def window(self) -> bpy.types.Window:
        return bpy.context.window_manager.windows[0]

    @property
    def view(self) -> bpy.types.Area:
        """The largest 3D viewport."""
        areas = [area for area in self.window.screen.areas if area.type == "VIEW_3D"]
        return max(areas, key=lambda area: area.width * area.height)

    def region(self, kind: str = "WINDOW") -> bpy.types.Region:
        return next(region for region in self.view.regions if region.type == kind)

    def panels(self) -> tuple[bpy.types.Area, bpy.types.Region]:
        """Where the panels are: the sidebar of the viewport, or the window of Properties."""
        if not self.is_in_properties:
            return self.view, self.region("UI")
        area = next(area for area in self.window.screen.areas if area.type == "PROPERTIES")
        return area, next(region for region in area.regions if region.type == "WINDOW")

    def context(self, kind: str = "WINDOW"):
        """An override of the context: the pointer in a region of the viewport."""
        return bpy.context.temp_override(
            window=self.window, area=self.view, region=self.region(kind)
        )

    def module(self, name: str) -> ModuleType:
        """A module of the installed extension ("addon.session.session")."""
        return import_module(f"{EXTENSION}.{name}")

    def event(self, kind: str, value: str, **keys: bool | str) -> None:
        x, y = self.mouse
        self.window.event_simulate(type=kind, value=value, x=x, y=y, **keys)

    def point(self, x: int, y: int) -> None:
        """Move the mouse."""
        self.mouse = (int(x), int(y))
        self.event("MOUSEMOVE", "NOTHING")

    def point_at_view(self) -> None:
        region = self.region()
        self.point(region.x + region.width // 2, region.y + region.height // 2)

    def press(self, key: str, **keys: bool) -> Steps:
        """A key or mouse button down and up, where the mouse is; modifiers as `ctrl=True`."""
        self.clicks += key == "LEFTMOUSE"
        self.event(key, "PRESS", **keys)
        self.event(key, "RELEASE", **keys)
        yield

    def wait_until(self, holds: Callable[[], bool], seconds: float = 30.0) -> Steps:
        """Wait for something that has to come, however busy the machine is; whether it came is the
        scenario's to judge."""
        for _ in range(round(seconds / PAUSE)):
            if holds():
                break
            yield
        yield

    def undo(self) -> Steps:
        self.point_at_view()
        yield
        yield from self.press("Z", ctrl=True)
        yield 0.3

    def redo(self) -> Steps:
        self.point_at_view()
        yield
        yield from self.press("Z", ctrl=True, shift=True)
        yield 0.3

    def play_frames(self, count: int) -> Steps:
        """Play the timeline until so many frames have passed, or a minute."""
        scene = bpy.context.scene
        passed = {scene.frame_current}
        bpy.ops.screen.animation_play()
        for _ in range(600):
            yield
            passed.add(scene.frame_current)
            if max(passed) - min(passed) >= count:
                break
        bpy.ops.screen.animation_cancel(restore_frame=False)
        yield 1.0

    def open_only(self, *wanted: str) -> None:
        """These panels are open and the add-on's others are closed; call it before the sidebar is
        drawn for the first time."""
        panels = [
            getattr(bpy.types, name) for name in dir(bpy.types) if name.startswith("HAPTIC_PT_")
        ]

        def depth(panel: type) -> int:
            parent = getattr(panel, "bl_parent_id", "")
            return 1 + depth(getattr(bpy.types, parent)) if parent else 0

        panels.sort(key=depth)
        for panel in reversed(panels):
            bpy.utils.unregister_class(panel)
        for panel in panels:
            others = set(getattr(panel, "bl_options", ())) - {"DEFAULT_CLOSED"}
            panel.bl_options = others if panel.__name__ in wanted else others | {"DEFAULT_CLOSED"}
            bpy.utils.register_class(panel)

    def show_properties(self, tab: str) -> Steps:
        """Look for panels in a tab of Properties, "SCENE" or "OBJECT", scrolled to its end."""
        self.is_in_properties = True
        self.panels()[0].spaces.active.context = tab
        yield 1.0
        yield from self.scroll_sidebar(60)

    def show_sidebar(self, tab: str = "Haptics") -> Steps:
        self.is_in_properties = False
        self.view.spaces.active.show_region_ui = True
        yield 1.0
        self.region("UI").active_panel_category = tab  # it has categories once it has been drawn
        yield 1.0

    def scroll_sidebar(self, notches: int) -> Steps:
        """Turn the mouse wheel over the panels, downwards, or upwards where ``notches`` are
        negative."""
        _, region = self.panels()
        self.point(region.x + region.width // 3, region.y + region.height // 2)
        yield 0.2
        for _ in range(abs(notches)):
            yield from self.press("WHEELDOWNMOUSE" if notches > 0 else "WHEELUPMOUSE")
        yield 0.5

    def under_mouse(self) -> str:
        """What the button under the mouse does, as Python: an operator's call, a property's data
        path, or nothing."""
        area, region = self.panels()
        with bpy.context.temp_override(window=self.window, area=area, region=region):
            for ask in (bpy.ops.ui.copy_python_command_button, bpy.ops.ui.copy_data_path_button):
                if ask.poll():
                    ask()
                    return bpy.context.window_manager.clipboard
        return ""

    def open_panel(self, switch: str) -> Steps:
        """Open a panel of Properties by its header, which has the check box of a property or, at
        its right end, another button: Blender keeps it as closed as it was when the window
        opened."""
        yield from self.click_button(switch, at=0.13, columns=(0.2, 0.86))

    def click_button(self, wanted: str, **place: object) -> Steps:
        """Click the panels' button that `point_at` finds."""
        yield from self.point_at(wanted, **place)
        yield from self.press("LEFTMOUSE")
        yield 0.3

    def click_beside(self, wanted: str, at: float, **place: object) -> Steps:
        """Click what stands in the line of a button of the sidebar, at a part of the width, and
        opens a popover."""
        yield from self.click_button(wanted, at=at, **place)
        yield 1.0

    def click_in_popup(self, wanted: str, right: int, up: int) -> Steps:
        """Click a button of an open popover or menu, so many pixels from the mouse, or one near
        there."""
        x, y = self.mouse
        passed = []
        for near in (0, 8, -8, 16, -16):
            self.point(x + right, y + up + near)
            yield 0.3
            passed.append(self.under_mouse().removeprefix("bpy.ops."))
            if passed[-1].split("(")[0] == wanted:
                yield from self.press("LEFTMOUSE")
                yield 0.5
                return
        self.save_picture("popup")
        raise AssertionError(f"no button for {wanted} in the popup; there are {passed}")

    def enter(self, wanted: str, number: str) -> Steps:
        """Click a field with a number, and type another one."""
        yield from self.click_button(wanted)
        for character in number:
            self.event(KEYS[character], "PRESS", unicode=character)
            yield
        yield from self.press("RET")
        yield 0.3

    def drag(self, wanted: str, right: int) -> Steps:
        """Drag a slider by so many pixels to the right."""
        yield from self.point_at(wanted)
        self.clicks += 1
        self.event("LEFTMOUSE", "PRESS")
        for _ in range(4):
            yield 0.1
            self.point(self.mouse[0] + right / 4, self.mouse[1])
        yield
        self.event("LEFTMOUSE", "RELEASE")
        yield 0.3

    def point_at(
        self,
        wanted: str,
        at: float | None = None,
        # Buttons may share a line; check boxes of headers stand at a fifth of the width.
        columns: tuple[float, ...] = (0.4, 0.82, 0.15, 0.755, 0.945, 0.9),
    ) -> Steps:
        """Move the mouse to the panels' button for an operator ("haptic.add_source") or a property
        ("haptics.kappa"), also where one has to scroll to it. ``at``: the part of the width to move
        to, beside it. ``columns``: parts of the width at which it is looked for."""
        passed: set[str] = set()
        for notches in (0, 60, -120, 12, 12, 12):
            if notches:
                yield from self.scroll_sidebar(notches)
            if (yield from self._point_in_view(wanted, passed, at, columns)):
                return
        raise AssertionError(
            f"no button for {wanted} in the panels; there are {sorted(passed - {''})}"
        )

    def _point_in_view(
        self, wanted: str, passed: set[str], at: float | None, columns: tuple[float, ...]
    ) -> Generator[float, None, bool]:
        """Move the mouse to the button if it is in sight; returns whether it is. ``passed``: what
        the others do, to which those in sight are added."""
        _, region = self.panels()
        for fraction in columns:
            for y in range(region.y + region.height - 4, region.y, -10):
                self.point(region.x + int(fraction * region.width), y)
                yield 0.02
                passed.add(self.under_mouse().removeprefix("bpy.ops."))
                if not any(found.split("(")[0] == wanted for found in passed):
                    continue
                # Where redraws are slow, the button of a place before may still be the active one.
                yield 0.2
                if self.under_mouse().removeprefix("bpy.ops.").split("(")[0] == wanted:
                    if at is not None:
                        self.point(region.x + int(at * region.width), y)
                        yield 0.2
                    return True
        return False

    def use_theme(self, name: str) -> Steps:
        """A theme that Blender ships, by file name ("Blender_Light"; "Blender_Dark" is the
        default)."""
        themes = (
            Path(folder) / "interface_theme" / f"{name}.xml"
            for folder in bpy.utils.preset_paths("")
        )
        path = next(path for path in themes if path.is_file())
        bpy.ops.script.execute_preset(
            filepath=str(path), menu_idname="USERPREF_MT_interface_theme_presets"
        )
        yield 0.5

    def use_scale(self, scale: float) -> Steps:
        bpy.context.preferences.view.ui_scale = scale
        yield 1.0

    def screenshot(self, name: str) -> Steps:
        """A picture of the whole window, FOLDER/name.png, the mouse where nothing reacts to it."""
        region = self.region()
        self.point(region.x + region.width // 3, region.y + 20)
        yield 0.5
        self.save_picture(name)
        yield

    def save_picture(self, name: str) -> None:
        path = str(self.folder / f"{name}.png")
        # Software OpenGL has no front buffer to read: Blender's own screenshot would be black
        # there.
        if os.environ.get("DISPLAY") and shutil.which("import"):
            subprocess.run(["import", "-window", "root", path], check=True)
        else:
            with self.context():
                bpy.ops.screen.screenshot(filepath=path, check_existing=False)


def play(scenario: ModuleType, window: Window) -> Steps:
    """The scenario between two looks at what is registered: with the extension off before, on
    during and off after."""
    yield 1.0
    bpy.ops.preferences.addon_disable(module=EXTENSION)
    yield
    before = registered()
    bpy.ops.preferences.addon_enable(module=EXTENSION)
    yield
    yield from scenario.steps(window)
    bpy.ops.preferences.addon_disable(module=EXTENSION)
    yield
    window.seen["left after disabling"] = difference(before, registered())


def main(scenario_path: str, folder: str) -> None:
    specification = spec_from_file_location(Path(scenario_path).stem, scenario_path)
    scenario = module_from_spec(specification)
    specification.loader.exec_module(scenario)
    window = Window(Path(folder))
    steps = play(scenario, window)
    started = time.monotonic()

    def finish(error: str | None) -> None:
        report = {"error": error, "seconds": time.monotonic() - started, "seen": window.seen}
        (window.folder / "report.json").write_text(
            json.dumps(report, indent=1, default=bool), encoding="utf-8"
        )
        bpy.ops.wm.quit_blender()

    def turn() -> float | None:
        try:
            with bpy.context.temp_override(window=window.window):
                pause = next(steps)
        except StopIteration:
            return finish(None)
        except BaseException:
            error = traceback.format_exc()
            window.save_picture("failure")
            return finish(error)
        return PAUSE if pause is None else pause

    bpy.app.timers.register(turn, first_interval=2.0, persistent=True)


main(*sys.argv[sys.argv.index("--") + 1 :])
