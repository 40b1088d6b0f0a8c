"""A picture of one field file, made with VTK without a screen.

Coloured by one array (default: the first that is not constant; a vector by its magnitude). Faces of
stones and surfaces are shaded. ParaView opens the same file and has more options.
"""
import functools
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

from trackbed_post import read, write

SIZE = (1200, 500)  # pixels
BAR = 180           # pixels at the right edge, for the colour bar
COLOURS = 256
# Direction from the model to the eye, and the one that points up in the picture.
VIEWS = {"side": ((0, -1, 0), (0, 0, 1)), "end": ((-1, 0, 0), (0, 0, 1)),
         "top": ((0, 0, 1), (0, 1, 0)), "corner": ((-1, -2, 1), (0, 0, 1))}


def with_screen():
    """Debian's VTK needs X: without a display this command runs again under xvfb-run."""
    if os.environ.get("DISPLAY"):
        return
    if not shutil.which("xvfb-run"):
        raise read.Unreadable("there is no X display: install xvfb-run (Debian packages xvfb, "
                              "xauth)")
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


def colour_table(vtk, limits):
    """From dark to light: the order of the colours survives grey print and colour blindness."""
    import matplotlib
    table = vtk.vtkLookupTable()
    table.SetNumberOfTableValues(COLOURS)
    for k in range(COLOURS):
        table.SetTableValue(k, *matplotlib.colormaps["viridis"](k / (COLOURS - 1)))
    table.SetVectorModeToMagnitude()
    table.SetRange(limits)
    return table


def balls(vtk, grid, array, on_points):
    """Spheres at the cells of one point that have a radius, with the values of the array; None if
    there are none."""
    from vtk.util.numpy_support import numpy_to_vtk, vtk_to_numpy
    import numpy as np
    radius = grid.GetPointData().GetArray("radius")
    if radius is None:
        return None
    alone = np.flatnonzero(vtk_to_numpy(grid.GetCellTypesArray()) == vtk.VTK_VERTEX)
    if not len(alone):
        return None
    offsets = vtk_to_numpy(grid.GetCells().GetOffsetsArray())
    nodes = vtk_to_numpy(grid.GetCells().GetConnectivityArray())[offsets[alone]]
    values = vtk_to_numpy(array)[nodes if on_points else alone]
    if values.ndim > 1:
        values = np.linalg.norm(values, axis=1)
    points = vtk.vtkPoints()
    points.SetData(numpy_to_vtk(vtk_to_numpy(grid.GetPoints().GetData())[nodes], deep=True))
    centres = vtk.vtkPolyData()
    centres.SetPoints(points)
    for name, data in (("size", vtk_to_numpy(radius).ravel()[nodes]), ("value", values)):
        item = numpy_to_vtk(np.ascontiguousarray(data, dtype=float), deep=True)
        item.SetName(name)
        centres.GetPointData().AddArray(item)
    ball = vtk.vtkSphereSource()
    ball.SetRadius(1)
    glyphs = vtk.vtkGlyph3DMapper()
    glyphs.SetInputData(centres)
    glyphs.SetSourceConnection(ball.GetOutputPort())
    glyphs.SetScaleArray("size")
    glyphs.SetScaleModeToScaleByMagnitude()
    glyphs.SetScalarModeToUsePointFieldData()
    glyphs.SelectColorArray("value")
    return glyphs


def coloured(vtk, grid, name, unit):
    """Actors of the grid and their colour bar."""
    array, on_points = find_array(grid, name)
    table = colour_table(vtk, range_of(array))
    mapper = vtk.vtkDataSetMapper()
    mapper.SetInputData(grid)
    if on_points:
        mapper.SetScalarModeToUsePointFieldData()
    else:
        mapper.SetScalarModeToUseCellFieldData()
    mapper.SelectColorArray(array.GetName())
    actors = []
    for one in (mapper, balls(vtk, grid, array, on_points)):
        if one is None:
            continue
        one.SetLookupTable(table)
        one.SetScalarRange(range_of(array))
        actors.append(vtk.vtkActor())
        actors[-1].SetMapper(one)
    actors[0].GetProperty().SetPointSize(4)
    faces = {vtk.VTK_POLYGON, vtk.VTK_TRIANGLE}
    if grid.IsHomogeneous() and grid.GetCellType(0) not in faces:
        actors[0].GetProperty().LightingOff()
    bar = vtk.vtkScalarBarActor()
    bar.SetLookupTable(table)
    bar.SetTitle(array.GetName() + unit(array, on_points))
    bar.SetMaximumHeightInPixels(SIZE[1] // 2)
    bar.SetVerticalTitleSeparation(12)  # pixels
    bar.SetLabelFormat("%.3g")
    for text in (bar.GetTitleTextProperty(), bar.GetLabelTextProperty()):
        text.SetColor(0, 0, 0)
        text.ShadowOff()
        text.ItalicOff()
        text.BoldOff()
    return actors, bar


def look(camera, bounds, eye, up):
    """Parallel projection that shows all of a box, with space for the colour bar on the right."""
    import numpy as np
    low, high = np.array(bounds[::2]), np.array(bounds[1::2])
    corners = np.array([[(low, high)[k >> axis & 1][axis] for axis in range(3)] for k in range(8)])
    eye, up = (np.array(one, dtype=float) for one in (eye, up))
    eye /= np.linalg.norm(eye)
    right = np.cross(up, eye)
    right /= np.linalg.norm(right)
    above = np.cross(eye, right)
    wide, tall = (np.ptp(corners @ axis) for axis in (right, above))
    part = 1 - BAR / SIZE[0]
    scale = 0.55 * max(tall, wide / part * SIZE[1] / SIZE[0], 1e-9)
    # The focal point is in the middle of the picture, the model to its left.
    focus = (low + high) / 2 + right * scale * SIZE[0] / SIZE[1] * (1 - part)
    camera.ParallelProjectionOn()
    camera.SetParallelScale(scale)
    camera.SetFocalPoint(*focus)
    camera.SetPosition(*(focus + eye * 2 * np.linalg.norm(high - low)))
    camera.SetViewUp(*up)


def unit_of(path, array, on_points):
    """Unit of a dataset of a field file, which VTK does not read."""
    found = read.datasets(path)
    item = found.get(f"VTKHDF/{'Point' if on_points else 'Cell'}Data/{array.GetName()}")
    return f", {item.unit}" if item is not None and item.unit not in ("", "1") else ""


def draw(vtk, grid, name, path, view, unit):
    """Writes the picture; returns the number of colours of the grid (without background). VTK draws
    into memory, because it reports a file that cannot be written only on the screen."""
    from vtk.util.numpy_support import vtk_to_numpy
    renderer, window = vtk.vtkRenderer(), vtk.vtkRenderWindow()
    window.SetOffScreenRendering(1)
    window.SetSize(*SIZE)
    window.SetMultiSamples(0)  # no mixed colours at edges, so that the colours can be counted
    window.AddRenderer(renderer)
    renderer.SetBackground(1, 1, 1)
    actors, bar = coloured(vtk, grid, name, unit)
    for actor in actors:
        renderer.AddActor(actor)
    look(renderer.GetActiveCamera(), grid.GetBounds(), *VIEWS[view])
    renderer.ResetCameraClippingRange()
    shaded = [actor for actor in actors if actor.GetProperty().GetLighting()]
    for actor in shaded:
        actor.GetProperty().LightingOff()
    colours = count_colours(vtk, window)
    for actor in shaded:
        actor.GetProperty().LightingOn()
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
    colours = np.unique(pixels.astype(np.int64) @ [1 << 16, 1 << 8, 1])
    return np.count_nonzero(colours != 0xFFFFFF)  # white is the background


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
    colours = draw(vtk, grid, array, picture, view, functools.partial(unit_of, file))
    print(f"{picture}: {grid.GetNumberOfCells()} cells; the picture has {colours} different "
          "colours")
    if colours <= 1:
        plain = read.Unreadable("the picture is empty or of one colour: choose another --array")
        plain.code = 1
        raise plain
    return colours
