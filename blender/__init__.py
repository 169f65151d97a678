"""Hair curves in turbulent wind: a panel of the 3D viewport's sidebar."""

import bpy

from . import operators, panel, process, properties

CLASSES = [*properties.CLASSES, *operators.CLASSES, *panel.CLASSES]


def register():
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    bpy.types.Object.windswept = bpy.props.PointerProperty(type=properties.Settings)


def unregister():
    process.stop()
    del bpy.types.Object.windswept
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
