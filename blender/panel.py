"""The panel in the sidebar of the 3D viewport."""

import textwrap

import bpy

from . import process, result
from .operators import hair_of


class Windswept(bpy.types.Panel):
    bl_idname = "VIEW3D_PT_windswept"
    bl_label = "Hair in Wind"
    bl_category = "Windswept"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        hair = hair_of(context.object)
        if hair is None:
            layout.label(text="Select a hair curves object", icon="INFO")
            return
        settings = hair.windswept
        column = layout.column()
        column.enabled = process.running is None
        column.label(text=hair.name, icon="OUTLINER_OB_CURVES")
        column.prop(settings, "scalp")
        if settings.scalp is None and hair.data.surface is not None:
            column.label(text=f"The surface of the curves: {hair.data.surface.name}", icon="BLANK1")
        column.prop(settings, "bodies")
        column.prop(settings, "strands")
        column.separator()
        column.prop(settings, "wind")
        if settings.wind is not None and settings.wind.field is not None and settings.wind.field.type == "WIND":
            column.prop(settings.wind.field, "strength", text="Strength (m/s)")
        else:
            column.prop(settings, "speed")
        column.prop(settings, "particles")
        air = column.column()
        air.active = settings.particles
        air.prop(settings, "scale")
        air.prop(settings, "intensity")
        air.prop(settings, "spacing")
        column.separator()
        column.prop(settings, "substeps")
        column.prop(settings, "keys")
        if process.running is None:
            row = layout.row(align=True)
            row.operator("windswept.estimate")
            row.operator("windswept.simulate", icon="PLAY")
            if result.of(hair) is not None:
                layout.operator("windswept.remove", icon="X")
            says(layout, context, settings.said)
        else:
            part, line = process.running.progress()
            layout.progress(factor=part, text=f"{100 * part:.0f} %")
            layout.operator("windswept.cancel", icon="CANCEL")
            says(layout, context, line)


def says(layout, context, words):
    """Lines as wide as the sidebar, of about 7 pixels a letter."""
    width = max(int(context.region.width / context.preferences.system.ui_scale / 7), 20)
    column = layout.column(align=True)
    column.scale_y = 0.8
    for line in words.splitlines():
        for row in textwrap.wrap(line, width):
            column.label(text=row)


CLASSES = [Windswept]
