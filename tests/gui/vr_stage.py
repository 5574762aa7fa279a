"""A VR session as scenarios use it."""

import time

import bpy

KEY = "vr-controllers"


class Stage:
    """The session, and what happened when, by time.perf_counter: marks, blocks sent, turns of
    Blender's main loop, each of which draws a frame of the session, and calls, whose order and
    values the log has, too."""

    def __init__(self, window):
        self.window, self.marks, self.sent, self.called = window, [], {}, []
        self.outputs = window.module("addon.live_output.outputs")
        self.actions = window.module("plugins.vr.actions")
        self.vibrate, self.actions.vibrate = self.actions.vibrate, self.note
        self.ticks, self.ended = [], False
        bpy.app.timers.register(self.tick, persistent=True)

    def tick(self):
        self.ticks.append(time.perf_counter())
        return None if self.ended else 0.0

    def note(self, *arguments):
        self.called.append((time.perf_counter(), *arguments[1:]))
        return self.vibrate(*arguments)

    @property
    def output(self):
        return self.outputs.running().get(KEY)

    def mark(self, name):
        self.marks.append((name, time.perf_counter()))

    @property
    def runs(self):
        state = bpy.context.window_manager.xr_session_state
        return state is not None and state.is_running(bpy.context)

    def toggle(self):
        wanted, manager = not self.runs, bpy.context.window_manager
        # Half of the time in which software draws a frame.
        manager.xr_session_settings.show_floor = False
        bpy.context.preferences.system.viewport_aa = "OFF"
        with self.window.context():
            bpy.ops.wm.xr_session_toggle()
        yield from self.window.wait_until(
            lambda: self.runs if wanted else manager.xr_session_state is None
        )
        yield 1.0

    def connect(self):
        yield from self.window.wait_until(lambda: self.outputs.found(KEY) is not None)
        bpy.ops.haptic.connect_device(device=KEY)
        yield 0.3
