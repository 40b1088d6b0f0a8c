"""All fields of a run in ParaView, as they are meant to be seen: stones and sleepers in their
shapes, balls as spheres, ground, rail and wheels, with the times of the run.

    pvbatch postproc/paraview/view.py RESULT_DIR VIEW.pvsm [PICTURE.png]

writes a state file, which ParaView opens (File > Load State), and a picture of the last instant.
Without a screen: `xvfb-run -a pvbatch ...`.
"""
import pathlib
import sys

from paraview import simple

SIZE = [1600, 900]      # pixels
GREY, STEEL, BLACK = [0.62, 0.6, 0.57], [0.25, 0.27, 0.3], [0.0, 0.0, 0.0]
EYE, UP = (-0.15, -1.0, 0.35), [0.0, 0.0, 1.0]  # from where the model is seen
# Part -> kind of data, array and its unit; of vectors the magnitude is shown.
COLOURED_BY = {"stones": ("CELLS", "velocity", "m/s"), "ground": ("POINTS", "displacement", "m"),
               "contacts": ("CELLS", "force_size", "N"), "solids": ("POINTS", "displacement", "m")}
INSIDE = "contacts"  # of the stones: hidden if there are stones


def color(display, part, view, hidden):
    """Colours a display by the array of its part, with a bar."""
    place, array, unit = COLOURED_BY[part]
    simple.ColorBy(display, (place, array) if part == "contacts" else (place, array, "Magnitude"))
    display.RescaleTransferFunctionToDataRangeOverTime()
    table = simple.GetColorTransferFunction(array)
    table.ApplyPreset("Viridis (matplotlib)", True)
    bar = simple.GetScalarBar(table, view)
    bar.Title, bar.ComponentTitle = f"{part}: {array} ({unit})", ""
    bar.TitleColor = bar.LabelColor = BLACK
    display.SetScalarBarVisibility(view, not hidden)


def balls_of(stones, view):
    """Points with a radius, shown as spheres; nothing if there are none."""
    alone = simple.ExtractCellsByType(registrationName="balls", Input=stones,
                                      CellTypes=["Vertex"])
    alone.UpdatePipeline()
    if alone.GetDataInformation().GetNumberOfCells() == 0:
        simple.Delete(alone)
        return
    # The velocity of cells is given to their points, which carry the spheres.
    points = simple.CellDatatoPointData(registrationName="ball values", Input=alone)
    spheres = simple.Glyph(registrationName="spheres", Input=points, GlyphType="Sphere",
                           ScaleArray=["POINTS", "radius"], ScaleFactor=2.0,
                           GlyphMode="All Points")
    simple.ColorBy(simple.Show(spheres, view), ("POINTS", "velocity", "Magnitude"))
    simple.Hide(alone, view)
    simple.Hide(points, view)


def show(part, path, view, hidden):
    """Opens the series of one part."""
    source = simple.VTKHDFReader(registrationName=part, FileName=[str(path)])
    source.UpdatePipeline()
    display = simple.Show(source, view)
    display.Representation = "Surface"
    if part == "stones":
        balls_of(source, view)
    if part in COLOURED_BY:
        color(display, part, view, hidden)
    else:
        display.ColorArrayName = ["POINTS", ""]  # one colour
        display.DiffuseColor = STEEL if part == "train" else GREY
    if part == "surfaces":   # walls are transparent
        display.Opacity = 0.35
    if part == "train":
        display.LineWidth = 4
    if hidden:
        simple.Hide(source, view)
    return source


def look_at(source, view):
    """A view from the side and a little from above, in which the whole source is seen."""
    bounds = source.GetDataInformation().GetBounds()
    middle = [(bounds[2 * k] + bounds[2 * k + 1]) / 2 for k in range(3)]
    view.CameraFocalPoint, view.CameraViewUp = middle, UP
    view.CameraPosition = [x + e for x, e in zip(middle, EYE)]
    view.CameraParallelProjection = 1
    view.ResetCamera(*bounds)


def main(folder, state, picture=None):
    fields = pathlib.Path(folder) / "fields"
    found = sorted(fields.glob("*.vtkhdf.series"))
    if not found:
        sys.exit(f"{fields} contains no fields: run the deck with output.fields=true")
    simple._DisableFirstRenderCameraReset()
    view = simple.CreateRenderView(ViewSize=SIZE)
    view.UseColorPaletteForBackground = 0
    view.Background = [1, 1, 1]
    view.OrientationAxesVisibility = 1
    names = [path.name.split(".")[0] for path in found]
    sources = [show(name, path.resolve(), view, name == INSIDE and "stones" in names)
               for name, path in zip(names, found)]
    scene = simple.GetAnimationScene()
    scene.UpdateAnimationUsingDataTimeSteps()
    scene.GoToLast()
    # The train may be much longer than the bed.
    parts = dict(zip(names, sources))
    look_at(parts.get("stones") or parts.get("ground") or sources[0], view)
    simple.SaveState(str(state))
    if picture:
        simple.SaveScreenshot(str(picture), view, ImageResolution=SIZE)
    times = sorted({time for one in sources for time in (one.TimestepValues or [])})
    print(f"{state}: {', '.join(names)}; {len(times)} times"
          + (f" from {times[0]:g} to {times[-1]:g} s" if times else ""))


if __name__ == "__main__":
    if len(sys.argv) not in (3, 4):
        sys.exit(__doc__)
    main(*sys.argv[1:])
