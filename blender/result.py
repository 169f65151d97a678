"""The film as a hair curves object beside the one that was simulated."""

import bpy

#: File in the folder of a hair curves object, and the curves in it.
FILM = "film.usdc"


def of(hair):
    """The result of a hair curves object, if there is one."""
    return next((found for found in bpy.data.objects if found.windswept.source == hair), None)


def remove(hair):
    """Removes the result, and shows the hair again."""
    if (result := of(hair)) is not None:
        caches = [modifier.cache_file for modifier in result.modifiers if modifier.type == "MESH_SEQUENCE_CACHE"]
        bpy.data.batch_remove([result, result.data, *filter(None, caches)])
    hair.hide_viewport = hair.hide_render = False


def show(context, hair, film):
    """Makes the film a new result, with the hair's materials and collections, and hides the hair."""
    remove(hair)
    known = set(bpy.data.objects)
    bpy.ops.wm.usd_import(filepath=str(film), set_frame_range=False, import_materials=False, relative_path=True)
    (result,) = set(bpy.data.objects) - known
    result.name = f"{hair.name} in wind"
    # The film has the scene's unit, whatever Blender made of it.
    result.matrix_world.identity()
    for collection in list(result.users_collection):
        collection.objects.unlink(result)
    for collection in hair.users_collection:
        collection.objects.link(result)
    for material in hair.data.materials:
        result.data.materials.append(material)
    (cache,) = (modifier for modifier in result.modifiers if modifier.type == "MESH_SEQUENCE_CACHE")
    cache.cache_file.frame_offset = context.scene.frame_start
    result.windswept.source = hair
    hair.hide_viewport = hair.hide_render = True
    context.view_layer.objects.active = result
    return result
