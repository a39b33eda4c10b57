"""open3d_client.py FILE PICTURE: what Open3D reads of FILE, and how its viewer shows it."""
import sys

import open3d

source, picture = sys.argv[1:3]
mesh = open3d.io.read_triangle_mesh(source, True)
if len(mesh.triangles) == 0:
    print("RESULT no triangle was read")
    sys.exit()
if not mesh.has_vertex_normals():
    mesh.compute_vertex_normals()
viewer = open3d.visualization.Visualizer()
viewer.create_window(width=400, height=300)
viewer.add_geometry(mesh)
control = viewer.get_view_control()
control.set_front([0, 0, 1])
control.set_up([0, 1, 0])
control.set_zoom(0.6)
viewer.poll_events()
viewer.update_renderer()
viewer.capture_screen_image(picture, True)
viewer.destroy_window()
textures = sum(not texture.is_empty() for texture in mesh.textures)
print(f"RESULT ok: {len(mesh.triangles)} triangles, {textures} textures")
