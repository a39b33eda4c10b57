"""blender -b -P blender_client.py -- FILE PICTURE: imports FILE, renders it from its own camera or from where the left
camera stood, and prints "ok: ..." or the error in a line that begins with RESULT."""
import math
import sys

import bpy
import numpy

source, picture = sys.argv[sys.argv.index("--") + 1:]
notes = []
if not hasattr(numpy, "bool"):  # Debian's Blender 3.4 imports glTF with a name that its NumPy no longer has
    numpy.bool = bool
    if source.endswith(("glb", "gltf")):
        notes.append("numpy.bool = bool was needed")
bpy.ops.wm.read_factory_settings(use_empty=True)
importers = {
    "glb": lambda: bpy.ops.import_scene.gltf(filepath=source),
    "gltf": lambda: bpy.ops.import_scene.gltf(filepath=source),
    "obj": lambda: bpy.ops.wm.obj_import(filepath=source, forward_axis="NEGATIVE_Z", up_axis="Y"),
    "ply": lambda: bpy.ops.import_mesh.ply(filepath=source),
    "stl": lambda: bpy.ops.import_mesh.stl(filepath=source),
    "usdz": lambda: bpy.ops.wm.usd_import(filepath=source),
}
kind = source.rsplit(".", 1)[1]
try:
    importers[kind]()
    scene = bpy.context.scene
    meshes = [o for o in scene.objects if o.type == "MESH"]
    if not meshes:
        raise RuntimeError("no mesh was imported")
    cameras = [o for o in scene.objects if o.type == "CAMERA"]
    images = [image for image in bpy.data.images if image.size[0] > 0]
    if not cameras:
        cameras = [bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))]
        scene.collection.objects.link(cameras[0])
        cameras[0].data.angle = math.radians(62)
        if kind not in ("ply", "stl"):  # which are imported as they are, with +Y up
            cameras[0].rotation_euler = (math.pi / 2, 0, 0)
    if kind == "ply":  # Blender shows vertex colours only by a material that asks for them
        material = bpy.data.materials.new("colours")
        material.use_nodes = True
        colours = material.node_tree.nodes.new("ShaderNodeVertexColor")
        material.node_tree.links.new(colours.outputs[0], material.node_tree.nodes["Principled BSDF"].inputs["Base Color"])
        meshes[0].data.materials.append(material)
    world = bpy.data.worlds.new("grey")
    world.use_nodes = True
    world.node_tree.nodes["Background"].inputs[0].default_value = (0.5, 0.5, 0.5, 1)
    scene.world = world
    scene.camera = cameras[0]
    scene.render.engine = "CYCLES"
    scene.cycles.samples = 8
    scene.cycles.use_denoising = False
    scene.render.resolution_x, scene.render.resolution_y = 320, 240
    scene.view_settings.view_transform = "Standard"
    scene.render.filepath = picture
    bpy.ops.render.render(write_still=True)
    triangles = sum(len(o.data.polygons) for o in meshes)
    print(f"RESULT ok: {triangles} triangles in {len(meshes)} objects, {len(images)} textures", *notes, sep=", ")
except Exception as error:  # whatever an importer throws is the finding
    # Blender writes its own line without an end before; what went wrong stands last.
    print("\nRESULT " + " ".join(str(error).split())[-160:])
