"""A picture of one field file, made with VTK without a screen.

Coloured by one array (default: the first that is not constant; a vector by its magnitude). Faces of
stones and surfaces are shaded. ParaView opens the same file and has more options.
"""
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

from trackbed_post import read, write

SIZE = (1200, 500)  # pixels
# Direction from the model to the eye, and the one that points up in the picture.
VIEWS = {"side": ((0, -1, 0), (0, 0, 1)), "end": ((-1, 0, 0), (0, 0, 1)),
         "top": ((0, 0, 1), (0, 1, 0)), "corner": ((-1, -2, 1), (0, 0, 1))}


def with_screen():
    """Debian's VTK needs X: without a display this command runs again under xvfb-run."""
    if os.environ.get("DISPLAY"):
        return
    if not shutil.which("xvfb-run"):
        raise SystemExit("there is no X display: install xvfb-run (Debian packages xvfb, xauth)")
    # Without a file of ours xvfb-run ends with 5 now and then: it removes its folder while xauth
    # still writes there.
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        done = subprocess.run(["xvfb-run", "-a", "-f", os.path.join(folder, "Xauthority"),
                               sys.executable, "-m", "trackbed_post", *sys.argv[1:]], check=False,
                              env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)})
    sys.exit(done.returncode)


def read_grid(vtk, path):
    reader = vtk.vtkHDFReader()
    if not reader.CanReadFile(path):
        raise read.Unreadable(f"{path} is not a VTKHDF file")
    reader.SetFileName(path)
    reader.Update()
    return reader.GetOutput()


def range_of(array):
    """(smallest, largest) value; the magnitude of vectors."""
    return array.GetRange(-1 if array.GetNumberOfComponents() > 1 else 0)


def find_array(grid, name):
    """(array, whether it is point data): the one named, or the first that varies, or any."""
    arrays = [(data.GetArray(k), on_points)
              for data, on_points in ((grid.GetPointData(), True), (grid.GetCellData(), False))
              for k in range(data.GetNumberOfArrays())]
    names = ", ".join(sorted({each[0].GetName() for each in arrays}))
    if not arrays:
        raise read.Unreadable("the file has no array")
    if name is not None:
        arrays = [each for each in arrays if each[0].GetName() == name]
    if not arrays:
        raise read.Unreadable(f"the file has no array {name}; its arrays: {names}")
    varying = [each for each in arrays if range_of(each[0])[0] < range_of(each[0])[1]]
    return (varying or arrays)[0]


def coloured(vtk, grid, name):
    """Actor of the grid and its colour bar."""
    array, on_points = find_array(grid, name)
    mapper = vtk.vtkDataSetMapper()
    mapper.SetInputData(grid)
    table = vtk.vtkLookupTable()
    table.SetHueRange(0.667, 0)  # blue is low, red is high
    if array.GetNumberOfComponents() > 1:
        table.SetVectorModeToMagnitude()
    mapper.SetLookupTable(table)
    mapper.SetScalarRange(range_of(array))
    if on_points:
        mapper.SetScalarModeToUsePointFieldData()
    else:
        mapper.SetScalarModeToUseCellFieldData()
    mapper.SelectColorArray(array.GetName())
    actor, bar = vtk.vtkActor(), vtk.vtkScalarBarActor()
    actor.SetMapper(mapper)
    actor.GetProperty().SetPointSize(4)
    faces = {vtk.VTK_POLYGON, vtk.VTK_TRIANGLE}
    if grid.IsHomogeneous() and grid.GetCellType(0) not in faces:
        actor.GetProperty().LightingOff()
    bar.SetLookupTable(table)
    bar.SetTitle(array.GetName())
    bar.SetMaximumHeightInPixels(SIZE[1] // 2)
    return actor, bar


def draw(vtk, grid, name, path, view):
    """Writes the picture; returns the number of colours of the grid (without background). VTK draws
    into memory, because it reports a file that cannot be written only on the screen."""
    from vtk.util.numpy_support import vtk_to_numpy
    renderer, window = vtk.vtkRenderer(), vtk.vtkRenderWindow()
    window.SetOffScreenRendering(1)
    window.SetSize(*SIZE)
    window.SetMultiSamples(0)  # no mixed colours at edges, so that the colours can be counted
    window.AddRenderer(renderer)
    renderer.SetBackground(1, 1, 1)
    actor, bar = coloured(vtk, grid, name)
    renderer.AddActor(actor)
    camera = renderer.GetActiveCamera()
    camera.ParallelProjectionOn()
    eye, up = VIEWS[view]
    camera.SetPosition(*eye)
    camera.SetFocalPoint(0, 0, 0)
    camera.SetViewUp(*up)
    renderer.ResetCamera()
    camera.Zoom(1.6 if view == "side" else 1.2)
    colours = count_colours(vtk, window)
    renderer.AddActor2D(bar)
    grabbed = grab(vtk, window)
    writer = vtk.vtkPNGWriter()
    writer.WriteToMemoryOn()
    writer.SetInputConnection(grabbed.GetOutputPort())
    writer.Write()
    write.whole(path, vtk_to_numpy(writer.GetResult()).tobytes())
    return colours


def grab(vtk, window):
    window.Render()
    grabbed = vtk.vtkWindowToImageFilter()
    grabbed.SetInput(window)
    grabbed.ReadFrontBufferOff()
    grabbed.Update()
    return grabbed


def count_colours(vtk, window):
    from vtk.util.numpy_support import vtk_to_numpy
    import numpy as np
    pixels = vtk_to_numpy(grab(vtk, window).GetOutput().GetPointData().GetScalars())
    return len(np.unique(pixels[np.any(pixels != 255, axis=1)], axis=0))


def render(file, picture, array=None, view="side"):
    """Draws a VTKHDF file into a PNG file, seen from one of VIEWS; number of colours in it."""
    if not picture.endswith(".png"):
        raise read.Unreadable(f"{picture}: the name of the picture must end in .png")
    if not os.path.isfile(file):
        raise read.Unreadable(f"{file} does not exist or is not a file")
    write.folder(pathlib.Path(picture).parent)
    with_screen()
    import vtk
    grid = read_grid(vtk, file)
    colours = draw(vtk, grid, array, picture, view)
    print(f"{picture}: {grid.GetNumberOfCells()} cells; the picture has {colours} different "
          "colours")
    if colours <= 1:
        plain = read.Unreadable("the picture is empty or of one colour: choose another --array")
        plain.code = 1
        raise plain
    return colours
