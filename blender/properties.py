"""What the user sets for a hair curves object, kept in the blend file. Lengths are in metres whatever the scene's unit."""

import bpy
from bpy.props import BoolProperty, FloatProperty, IntProperty, PointerProperty, StringProperty


def is_mesh(_, candidate):
    return candidate.type == "MESH"


def blows(_, candidate):
    return candidate.type == "EMPTY"


class Settings(bpy.types.PropertyGroup):
    scalp: PointerProperty(
        name="Scalp",
        description="Mesh that the hair grows on and goes with; without it: the surface of the hair curves",
        type=bpy.types.Object,
        poll=is_mesh,
    )
    bodies: PointerProperty(
        name="Bodies",
        description="Collection whose meshes hair and air stay out of, besides the scalp",
        type=bpy.types.Collection,
    )
    wind: PointerProperty(
        name="Wind",
        description="A force field of type Wind, or any empty as an arrow: air blows along its Z axis",
        type=bpy.types.Object,
        poll=blows,
    )
    speed: FloatProperty(
        name="Speed (m/s)",
        description="Speed of the wind of an empty; that of a force field is its strength",
        default=3.0,
        min=0.0,
        soft_max=20.0,
    )
    scale: FloatProperty(
        name="Eddy scale (m)",
        description="How large eddies are: they measure about twice that across",
        default=0.04,
        min=1e-4,
        soft_max=0.5,
        precision=4,
    )
    intensity: FloatProperty(
        name="Intensity",
        description="How wild the wind is: rms speed of its eddies over that of the wind; 0: no eddies",
        default=0.6,
        min=0.0,
        soft_max=1.5,
    )
    particles: BoolProperty(
        name="Air particles",
        description="Air flows around hair and bodies; without particles hair feels the mean wind only, in a fast preview",
        default=True,
    )
    spacing: FloatProperty(
        name="Air spacing (m)",
        description="How fine the air is: half of it takes eight times the particles",
        default=0.025,
        min=1e-4,
        soft_max=0.1,
        precision=4,
    )
    strands: IntProperty(
        name="Strands",
        description="How many of the curves are simulated; the others follow them",
        default=200,
        min=1,
        soft_max=20000,
    )
    substeps: IntProperty(
        name="Substeps",
        description="Whole steps in each 1.4 ms: more for fast wind and fast bodies. A warning names the number to take",
        default=1,
        min=1,
        soft_max=16,
    )
    keys: PointerProperty(
        name="More keys",
        description="Text with a key of a scene on each line, as hair.youngs_modulus=1e9",
        type=bpy.types.Text,
    )
    source: PointerProperty(
        name="Source",
        description="Of a result: the hair curves that were simulated",
        type=bpy.types.Object,
    )
    said: StringProperty(description="What the last command said", options={"HIDDEN", "SKIP_SAVE"})


CLASSES = [Settings]
