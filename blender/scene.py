"""A Blender scene as a scene of windswept, in a folder: `scene.toml`, the groom and the bodies."""

from contextlib import contextmanager
from pathlib import Path

import bpy
import numpy as np

from . import wind
from .axes import of_windswept, rounded, unit
from .bodies import Poses
from .error import Unfit
from .hair import groom

#: Longest step [s], of which there are a whole number in each frame.
STEP = 1.4e-3
#: Room for the layer in which entering air is conditioned, 4 kernel radii thick [particle spacings].
FRINGE = 8


def folder_of(hair):
    """Folder of the files of a hair curves object, beside the blend file."""
    if not bpy.data.filepath:
        raise Unfit("Save the blend file first: simulated hair is kept in a folder beside it")
    return Path(bpy.path.abspath("//")) / "windswept" / bpy.path.clean_name(hair.name)


def scalp_of(hair):
    scalp = hair.windswept.scalp or hair.data.surface
    if scalp is None:
        raise Unfit(f"{hair.name}: has no scalp; choose the mesh that it grows on")
    return scalp


def write(context, hair, folder, progress=lambda part: None):
    """Writes what is to be simulated into the folder, and returns the scene file. Every frame of the scene is looked at.

    `progress` is called with the part of the frames that were.
    """
    import windswept as ws

    settings, scene = hair.windswept, context.scene
    scalp, metres = scalp_of(hair), unit(scene)
    others = [body for body in (settings.bodies.all_objects if settings.bodies else []) if body.type == "MESH" and body != scalp]
    bodies = [Poses(body) for body in [scalp, *others]]
    frames = range(scene.frame_start, scene.frame_end + 1)
    if len(frames) < 2:
        raise Unfit(f"The scene has frames {scene.frame_start} to {scene.frame_end}; expected two or more to simulate")
    velocities, before = [], scene.frame_current
    arrays = None
    looked_at = [hair, *(poses.body for poses in bodies), *filter(None, [settings.wind])]
    with shown(looked_at, context):
        try:
            for frame in frames:
                scene.frame_set(frame)
                graph = context.evaluated_depsgraph_get()
                if arrays is None:
                    arrays = groom(hair, graph, metres)
                for poses in bodies:
                    poses.add(graph, metres)
                velocities.append(wind.blowing(settings.wind, settings.speed, graph))
                progress(len(velocities) / len(frames))
        finally:
            scene.frame_set(before)

    fps = scene.render.fps / scene.render.fps_base
    times = np.arange(len(frames)) / fps
    folder.mkdir(parents=True, exist_ok=True)
    made_of = [poses.written(folder, times) for poses in bodies]
    # The groom's origin is that of the scalp's file, as hair goes with it.
    np.savez(folder / "groom.npz", **{**arrays, "points": arrays["points"] - made_of[0][1]})
    strands = len(arrays["offsets"]) - 1
    simulated = min(settings.strands, strands)
    made = ws.Scene(
        title=hair.name,
        gravity=rounded(metres * of_windswept(scene.gravity)) if scene.use_gravity else np.zeros(3),
        time=ws.Time(
            step=1 / (fps * np.ceil(1 / (fps * STEP))),
            substeps=settings.substeps,
            duration=times[-1],
            frame_rate=fps,
        ),
        hair=ws.Hair(
            file=str(folder / "groom.npz"),
            strands=simulated,
            fibres_per_strand=strands / simulated,
            body=bodies[0].name,
        ),
        body=[body for body, _ in made_of],
        air=ws.Air(**wind.keys(np.stack(velocities), times)),
    )
    if settings.particles:
        add_particles(made, settings, arrays["points"], arrays["offsets"], bodies[0])
    else:
        made.interaction.model = "drag"
    path = folder / "scene.toml"
    path.write_text(made.text_in(folder), encoding="utf-8")
    return path


def add_particles(made, settings, points, offsets, scalp):
    """Gives a scene air particles as far as hair with these points gets, around the scalp, with which they go."""
    import windswept as ws

    roots = points[offsets[:-1]]
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    length = (along[offsets[1:] - 1] - along[offsets[:-1]]).max()
    # A scalp takes at most a quarter of the box's cross-section.
    made.air.margin = max(np.ptp(roots, axis=0).max() / 2, 2 * settings.spacing)
    # Room for the fringe on every side: the margin cuts the box where wind does not enter.
    room = length + made.air.margin + FRINGE * settings.spacing
    made.air.box = ws.Bounds(min=rounded(roots.min(axis=0) - room), max=rounded(roots.max(axis=0) + room))
    made.air.spacing = settings.spacing
    if scalp.moves():
        made.air.follows = scalp.name
    if settings.intensity > 0:
        made.turbulence = ws.Turbulence(scale=settings.scale, intensity=settings.intensity)


@contextmanager
def shown(objects, context):
    """Shows hidden objects in the meantime: Blender does not evaluate what is hidden in viewports."""
    missing = [body.name for body in objects if body.name not in context.view_layer.objects]
    if missing:
        raise Unfit(f"{', '.join(missing)}: not in this view layer; link it, or include its collection")
    before = [(body, body.hide_viewport, body.hide_get()) for body in objects]
    try:
        for body, *_ in before:
            body.hide_viewport = False
            body.hide_set(False)
        context.view_layer.update()
        hidden = [body.name for body in objects if not body.visible_get()]
        if hidden:
            raise Unfit(f"{', '.join(hidden)}: in a hidden collection; show it")
        yield
    finally:
        for body, viewport, hidden in before:
            body.hide_viewport = viewport
            body.hide_set(hidden)
