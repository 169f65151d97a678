"""Simulate, estimate, cancel, remove."""

import os
from pathlib import Path

import bpy

from . import process, result, scene
from .axes import unit
from .error import Unfit


def hair_of(found):
    """The hair curves that an object is or is the result of."""
    if found is None or found.type != "CURVES":
        return None
    return found.windswept.source or found


class Background:
    """An operator that runs a job: in the background from a button, and to its end from a program. Esc cancels it."""

    @classmethod
    def poll(cls, context):
        if hair_of(context.object) is None:
            cls.poll_message_set("Select a hair curves object")
            return False
        return process.running is None

    def begin(self, context):
        """Starts the job; says why not, and returns False, where it cannot."""
        hair = hair_of(context.object)
        # Undo may replace the object while the job runs.
        self.hair = hair.name
        self.say(context, "Looking at the frames")
        windows = context.window_manager
        windows.progress_begin(0, 1)
        try:
            folder = scene.folder_of(hair)
            path = scene.write(context, hair, folder, windows.progress_update)
            process.running = process.Job(self.commands(hair, path, unit(context.scene)), folder)
            self.say(context, "Starting")
            return True
        # What the scene, a groom or a folder has that does not do; windswept's errors of scenes are ValueErrors.
        except (Unfit, ValueError, OSError) as error:
            self.fail(context, str(error))
            return False
        finally:
            windows.progress_end()

    def execute(self, context):
        if not self.begin(context):
            return {"CANCELLED"}
        try:
            process.running.wait()
        finally:
            # Ctrl-C ends the wait, and the job with it.
            if process.running.goes_on():
                process.stop()
        return self.end(context)

    def invoke(self, context, event):
        if not self.begin(context):
            return {"CANCELLED"}
        self.timer = context.window_manager.event_timer_add(0.25, window=context.window)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        if process.running is None or (event.type == "ESC" and event.value == "PRESS"):
            self.cancel(context)
            self.say(context, "Cancelled")
            return {"CANCELLED"}
        if event.type != "TIMER":
            return {"PASS_THROUGH"}
        if process.running.goes_on():
            redraw(context)
            return {"PASS_THROUGH"}
        context.window_manager.event_timer_remove(self.timer)
        return self.end(context)

    def cancel(self, context):
        """Ends the job; Blender calls it too when another file is opened."""
        process.stop()
        context.window_manager.event_timer_remove(self.timer)

    def end(self, context):
        job, process.running = process.running, None
        hair = bpy.data.objects.get(self.hair)
        if hair is None:
            self.report({"ERROR"}, f"{self.hair}: was removed or renamed while the simulation ran")
            return {"CANCELLED"}
        if job.failed:
            self.fail(context, job.error())
            return {"CANCELLED"}
        try:
            words = self.done(context, hair, job)
        # The film may be gone, or not what Blender reads.
        except (ValueError, OSError, RuntimeError) as error:
            self.fail(context, str(error))
            return {"CANCELLED"}
        self.say(context, "\n".join([words, *job.warnings()]))
        return {"FINISHED"}

    def say(self, context, words):
        if (hair := bpy.data.objects.get(self.hair)) is not None:
            hair.windswept.said = words
        redraw(context)

    def fail(self, context, words):
        self.say(context, words)
        self.report({"ERROR"}, words)


class Estimate(Background, bpy.types.Operator):
    """Try a few steps, and say how long the simulation takes"""

    bl_idname = "windswept.estimate"
    bl_label = "Estimate Time"

    def commands(self, hair, path, unit):
        return [["-m", "windswept", "check", str(path), "--formats", "vtkhdf", *more_keys(hair)]]

    def done(self, context, hair, job):
        return next((line for line in job.lines() if line.startswith("run ")), "").removeprefix("run ").strip()


class Simulate(Background, bpy.types.Operator):
    """Simulate the hair in all frames of the scene"""

    bl_idname = "windswept.simulate"
    bl_label = "Simulate"
    bl_options = {"UNDO"}

    def commands(self, hair, path, unit):
        run, film = str(path.parent / "run"), str(path.parent / f"new-{result.FILM}")
        export = ["--format", "usdc", "--out", film, "--followers", "--hair-only", "--up", "z", "--scale", repr(unit), "--overwrite"]
        return [
            ["-m", "windswept", "run", str(path), "--out", run, "--formats", "vtkhdf", "--overwrite", *more_keys(hair)],
            ["-m", "windswept", "export", run, *export],
            [str(Path(__file__).parent / "look.py"), film, str(path.parent / "groom.npz"), repr(unit)],
        ]

    def done(self, context, hair, job):
        folder = scene.folder_of(hair)
        film = folder / result.FILM
        # Blender keeps the file of a result open, and Windows replaces no open file.
        result.remove(hair)
        os.replace(folder / f"new-{result.FILM}", film)
        result.show(context, hair, film)
        return next((line for line in job.lines() if "steps in" in line), "").rpartition(": ")[2]


class Cancel(bpy.types.Operator):
    """End the simulation"""

    bl_idname = "windswept.cancel"
    bl_label = "Cancel"

    @classmethod
    def poll(cls, context):
        return process.running is not None

    def execute(self, context):
        process.stop()
        return {"FINISHED"}


class Remove(bpy.types.Operator):
    """Remove the result, and show the hair curves that it was simulated from"""

    bl_idname = "windswept.remove"
    bl_label = "Remove Result"
    bl_options = {"UNDO"}

    @classmethod
    def poll(cls, context):
        return process.running is None and (hair := hair_of(context.object)) is not None and result.of(hair) is not None

    def execute(self, context):
        hair = hair_of(context.object)
        result.remove(hair)
        context.view_layer.objects.active = hair
        return {"FINISHED"}


def more_keys(hair):
    """Arguments for the lines of the text that has more keys."""
    text = hair.windswept.keys
    lines = [line.body.strip() for line in text.lines] if text else []
    return [word for line in lines if line and not line.startswith("#") for word in ("--set", line)]


def redraw(context):
    for window in context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "VIEW_3D":
                area.tag_redraw()


CLASSES = [Estimate, Simulate, Cancel, Remove]
