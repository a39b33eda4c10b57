"""vtk_client.py FILE PICTURE: FILE as VTK's own readers and importers show it."""
import sys

import vtk

source, picture = sys.argv[1:3]
kind = source.rsplit(".", 1)[1]
window = vtk.vtkRenderWindow()
window.SetOffScreenRendering(1)
window.SetSize(400, 300)
renderer = vtk.vtkRenderer()
renderer.SetBackground(0.2, 0.2, 0.33)
window.AddRenderer(renderer)
if kind in ("glb", "gltf", "obj"):
    importer = vtk.vtkOBJImporter() if kind == "obj" else vtk.vtkGLTFImporter()
    importer.SetFileName(source)
    if kind == "obj":
        importer.SetFileNameMTL(source[:-3] + "mtl")
        importer.SetTexturePath(source.rsplit("/", 1)[0])
    importer.SetRenderWindow(window)
    importer.Update()
    renderer = importer.GetRenderer()
else:
    reader = vtk.vtkPLYReader() if kind == "ply" else vtk.vtkSTLReader()
    reader.SetFileName(source)
    mapper = vtk.vtkPolyDataMapper()
    mapper.SetInputConnection(reader.GetOutputPort())
    actor = vtk.vtkActor()
    actor.SetMapper(mapper)
    renderer.AddActor(actor)
renderer.ResetCamera()
window.Render()
triangles, actors = 0, renderer.GetActors()
actors.InitTraversal()
for _ in range(actors.GetNumberOfItems()):
    triangles += actors.GetNextActor().GetMapper().GetInput().GetNumberOfPolys()
capture = vtk.vtkWindowToImageFilter()
capture.SetInput(window)
writer = vtk.vtkPNGWriter()
writer.SetFileName(picture)
writer.SetInputConnection(capture.GetOutputPort())
writer.Write()
print(f"RESULT ok: {triangles} triangles" if triangles else "RESULT no triangle was read")
