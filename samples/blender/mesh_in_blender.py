"""Meshes the sample pair inside Blender and renders it as the left camera saw it.

blender -b --python-use-system-env -P samples/blender/mesh_in_blender.py -- relief.png [relief.blend]
"""
import pathlib
import sys

import bpy
import hexrelief
import numpy as np

samples = pathlib.Path(__file__).parent.parent
picture = samples / "left.png"


def blender_mesh(relief):
    """Blender's mesh of a hexrelief.Mesh, in the same coordinates: a camera at the origin looks along -Z."""
    mesh = bpy.data.meshes.new("relief")
    corners = relief.faces.ravel()
    mesh.vertices.add(len(relief.vertices))
    mesh.vertices.foreach_set("co", relief.vertices.ravel())
    mesh.loops.add(len(corners))
    mesh.loops.foreach_set("vertex_index", corners.astype(np.int32))
    mesh.polygons.add(len(relief.faces))
    mesh.polygons.foreach_set("loop_start", np.arange(0, len(corners), 3, dtype=np.int32))
    mesh.polygons.foreach_set("loop_total", np.full(len(relief.faces), 3, dtype=np.int32))
    uv = relief.uv * (1, -1) + (0, 1)  # Blender counts v from the bottom
    mesh.uv_layers.new().data.foreach_set("uv", uv[corners].astype(np.float32).ravel())
    mesh.update(calc_edges=True)
    return mesh


def photograph(file):
    """A material that shows the picture as it is, without light."""
    material = bpy.data.materials.new("photograph")
    material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    nodes.clear()
    texture = nodes.new("ShaderNodeTexImage")
    texture.image = bpy.data.images.load(str(file))
    emission = nodes.new("ShaderNodeEmission")
    links.new(texture.outputs["Color"], emission.inputs["Color"])
    links.new(emission.outputs["Emission"], nodes.new("ShaderNodeOutputMaterial").inputs["Surface"])
    return material


def left_camera(focal_px, cx, cy, width, height):
    data = bpy.data.cameras.new("left")
    data.sensor_fit, data.sensor_width = "HORIZONTAL", 36
    data.lens = 36 * focal_px / width
    data.shift_x, data.shift_y = (width / 2 - cx) / width, (cy - height / 2) / width
    data.clip_start, data.clip_end = 0.01, 1000
    return data


left, right = (hexrelief.read_picture(samples / f"{side}.png") for side in ("left", "right"))
disparity = hexrelief.compute_disparity(left, right, camera=samples / "calib.txt")
relief = hexrelief.mesh(disparity, color=left, camera=samples / "calib.txt")
camera = relief.report["input"]["calibration"]

scene = bpy.data.scenes.new("relief")
body = bpy.data.objects.new("relief", blender_mesh(relief))
body.data.materials.append(photograph(picture))
scene.collection.objects.link(body)
height, width = left.shape[:2]
scene.camera = bpy.data.objects.new("left", left_camera(camera["focal_px"], camera["cx"], camera["cy"], width, height))
scene.collection.objects.link(scene.camera)

arguments = sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else ["relief.png"]
scene.render.engine, scene.cycles.samples = "CYCLES", 4
scene.cycles.use_denoising = False  # Debian builds Blender without the denoiser
scene.view_settings.view_transform = "Standard"  # colours as they are
scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = width, height, 100
scene.render.dither_intensity = 0
scene.render.filepath = str(pathlib.Path(arguments[0]).resolve())
bpy.ops.render.render(write_still=True, scene=scene.name)
if len(arguments) > 1:
    bpy.ops.wm.save_as_mainfile(filepath=str(pathlib.Path(arguments[1]).resolve()))
print(relief, "in Blender", bpy.app.version_string)
