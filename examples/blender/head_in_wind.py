"""Makes a blend file with hair on a head that turns, simulates it by the extension, and renders frames with Cycles.

    blender --background --python examples/blender/head_in_wind.py -- out/blender

A Python with Blender as a module (`pip install bpy`) takes the same words without `blender --background --python`. The extension
must be installed and enabled. Some minutes on two cores.
"""

import sys
from pathlib import Path

import bpy
import numpy as np
from mathutils import Vector

folder = Path(sys.argv[-1]).resolve()
folder.mkdir(parents=True, exist_ok=True)
bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.preferences.addon_enable(module="bl_ext.user_default.windswept")
scene = bpy.context.scene
scene.frame_start, scene.frame_end = 1, 25
bpy.ops.wm.save_as_mainfile(filepath=str(folder / "head.blend"))


def material(name, shader, **inputs):
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    nodes = made.node_tree.nodes
    nodes.clear()
    node, output = nodes.new(shader), nodes.new("ShaderNodeOutputMaterial")
    made.node_tree.links.new(node.outputs[0], output.inputs["Surface"])
    for key, value in inputs.items():
        node.inputs[key.replace("_", " ")].default_value = value
    return made


# The head, which turns to its right. It is 27 cm high, and faces -Y.
mesh = Path(__file__).parents[1] / "scenes/head.obj"
bpy.ops.wm.obj_import(filepath=str(mesh), use_split_groups=False, import_vertex_groups=True)
head = bpy.context.object
bpy.ops.object.transform_apply()
bpy.ops.object.shade_smooth()
head.data.materials.clear()
head.data.materials.append(material("Skin", "ShaderNodeBsdfPrincipled", Base_Color=(0.62, 0.42, 0.33, 1), Roughness=0.5))
for frame, turn in [(1, 0.0), (15, 0.0), (25, -0.7)]:
    head.rotation_euler[2] = turn
    head.keyframe_insert("rotation_euler", frame=frame)

# Hair on the vertex group "scalp", combed back and down.
rng = np.random.default_rng(1)
scalp = head.vertex_groups["scalp"].index
grown = {vertex.index for vertex in head.data.vertices if any(group.group == scalp for group in vertex.groups)}
head.data.calc_loop_triangles()
faces = [face.vertices for face in head.data.loop_triangles if grown.issuperset(face.vertices)]
corners = np.array([[head.data.vertices[k].co for k in face] for face in faces])
across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
area = np.linalg.norm(across, axis=1)
hairs, points, length = 6000, 14, 0.24
chosen = rng.choice(len(area), hairs, p=area / area.sum())
part = np.sort(rng.random((hairs, 2)), axis=1)
roots = np.einsum("ik,ikj->ij", np.stack([part[:, 0], part[:, 1] - part[:, 0], 1 - part[:, 1]], axis=1), corners[chosen])
normals = across[chosen] / area[chosen, None]
hair = [roots]
way = 0.4 * normals + [0, 0.6, 0.15]
lengths = length * (1 - 0.25 * rng.random((hairs, 1)))
for _ in range(points - 1):
    way = 0.8 * way + [0, 0.05, -0.2] + 0.02 * rng.normal(size=(hairs, 3))
    tips = hair[-1] + lengths / (points - 1) * way / np.linalg.norm(way, axis=1, keepdims=True)
    # Hair lies on the head, 3 mm off it at least.
    for k, tip in enumerate(tips):
        _, place, normal, _ = head.closest_point_on_mesh(tip)
        tips[k] += normal * max(0.003 - normal.dot(Vector(tip) - place), 0)
    way = (tips - hair[-1]) / np.linalg.norm(tips - hair[-1], axis=1, keepdims=True)
    hair.append(tips)
curves = bpy.data.hair_curves.new("Hair")
curves.add_curves([points] * hairs)
curves.attributes["position"].data.foreach_set("vector", np.stack(hair, axis=1).astype(np.float32).ravel())
thickness = np.tile(np.linspace(3.5e-4, 1e-4, points), hairs)
curves.attributes.new("radius", "FLOAT", "POINT").data.foreach_set("value", thickness.astype(np.float32))
curves.surface = head
curves.materials.append(material("Hair", "ShaderNodeBsdfHairPrincipled", Color=(0.10, 0.04, 0.018, 1), Roughness=0.35))
groom = bpy.data.objects.new("Hair", curves)
scene.collection.objects.link(groom)
groom.parent = head

# Wind from the front, a little from its left.
wind = bpy.data.objects.new("Wind", None)
wind.empty_display_type = "SINGLE_ARROW"
wind.rotation_euler = (-np.pi / 2, 0, 0.35)
wind.location = (0, -0.4, 0)
scene.collection.objects.link(wind)
settings = groom.windswept
settings.wind, settings.speed, settings.scale, settings.intensity, settings.spacing = wind, 5.0, 0.06, 0.8, 0.04
settings.keys = bpy.data.texts.new("Keys")
settings.keys.from_string("hair.youngs_modulus = 1e9\nhair.points = 8\nbody.head.resolution = 0.004\n")
settings.strands, settings.particles = 80, False

# Camera, lights, and a small picture.
camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
camera.location, camera.rotation_euler, camera.data.lens = (1.15, -0.35, 0.08), (np.radians(88), 0, np.radians(67)), 62
scene.collection.objects.link(camera)
scene.camera = camera
for place, size, power in [((0.8, -0.9, 0.9), 0.6, 22), ((-0.4, 0.9, 0.8), 0.4, 18)]:
    lamp = bpy.data.objects.new("Light", bpy.data.lights.new("Light", "AREA"))
    lamp.location, lamp.data.size, lamp.data.energy = place, size, power
    lamp.rotation_euler = (-lamp.location).to_track_quat("-Z", "Y").to_euler()
    scene.collection.objects.link(lamp)
scene.world = bpy.data.worlds.new("World")
scene.world.use_nodes = True
scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.25, 0.3, 0.36, 1)
scene.render.engine = "CYCLES"
scene.cycles.device, scene.cycles.samples, scene.cycles.use_denoising = "CPU", 16, True
scene.render.resolution_x, scene.render.resolution_y = 400, 360

bpy.context.view_layer.objects.active = groom
bpy.ops.wm.save_mainfile()
bpy.ops.windswept.estimate()
print(settings.said)
bpy.ops.windswept.simulate()
print(settings.said)
bpy.ops.wm.save_mainfile()
for frame in (1, 13, 25):
    scene.frame_set(frame)
    scene.render.filepath = str(folder / f"head-{frame:02}.png")
    bpy.ops.render.render(write_still=True)
