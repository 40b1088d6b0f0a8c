"""All fields of a run in ParaView, as they are meant to be seen: stones and sleepers in their
shapes, balls as spheres, ground, rail and wheels, with the times of the run.

    pvbatch postproc/paraview/view.py RESULT_DIR VIEW.pvsm [PICTURE.png [TIME]]

writes a state file, which ParaView opens (File > Load State), and a picture of the instant at TIME
(s), by default of the last one with a wheel within the other parts, or of the last one. Colours
have the range of this instant. Ground and solids are drawn displaced, as stones touch them. Without
a screen: `xvfb-run -a pvbatch ...`.
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
AT_REST = ("ground", "solids")  # their files have the undisplaced points


def color(display, part, view, hidden):
    """Colours a display by the array of its part, with a bar and a range of its own. Balls share
    those of the stones."""
    place, array, unit = COLOURED_BY[part]
    own = part != "stones"
    display.UseSeparateColorMap = own
    simple.ColorBy(display, (place, array) if part == "contacts" else (place, array, "Magnitude"),
                   separate=own)
    display.RescaleTransferFunctionToDataRange(False, True)
    table = simple.GetColorTransferFunction(array, display, separate=own)
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


def opened(part, path):
    """The series of one part, displaced if its points are not."""
    source = simple.VTKHDFReader(registrationName=part, FileName=[str(path)])
    source.UpdatePipeline()
    if part not in AT_REST:
        return source, source
    moved = simple.WarpByVector(registrationName=f"{part} displaced", Input=source,
                                Vectors=["POINTS", "displacement"], ScaleFactor=1.0)
    return source, moved


def show(part, source, view, hidden):
    """Draws one part at the present time."""
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


def look_at(source, view):
    """A view from the side and a little from above, in which the whole source is seen."""
    bounds = source.GetDataInformation().GetBounds()
    middle = [(bounds[2 * k] + bounds[2 * k + 1]) / 2 for k in range(3)]
    view.CameraFocalPoint, view.CameraViewUp = middle, UP
    view.CameraPosition = [x + e for x, e in zip(middle, EYE)]
    view.CameraParallelProjection = 1
    view.ResetCamera(*bounds)


def instant(sources, given):
    """s: that of the files nearest to the given one; without one the last with a train, if any."""
    times = sorted({time for one in sources.values() for time in (one.TimestepValues or [])})
    if not times:
        return times, None
    if given is not None:
        return times, min(times, key=lambda time: abs(time - given))
    if "train" not in sources:
        return times, times[-1]
    return times, last_on_bed(sources)


def last_on_bed(sources):
    """s: the last instant of the train's files at which a wheel is within the other parts along
    x; the last one without."""
    others = [one.GetDataInformation().GetBounds()[:2] for name, one in sources.items()
              if name != "train"]
    low = min((one[0] for one in others), default=0.0)
    high = max((one[1] for one in others), default=low)
    # Rails are lines.
    wheels = simple.ExtractCellsByType(Input=sources["train"], CellTypes=["Polygon"])
    found = max(sources["train"].TimestepValues)
    for time in sorted(sources["train"].TimestepValues, reverse=True):
        wheels.UpdatePipeline(time)
        bounds = wheels.GetDataInformation().GetBounds()
        if bounds[0] < high and bounds[1] > low:
            found = time
            break
    simple.Delete(wheels)
    return found


def main(folder, state, picture=None, time=None):
    fields = pathlib.Path(folder) / "fields"
    found = sorted(fields.glob("*.hdf.series"))
    if not found:
        sys.exit(f"{fields} contains no fields: run the deck with output.fields=true")
    simple._DisableFirstRenderCameraReset()
    view = simple.CreateRenderView(ViewSize=SIZE)
    view.UseColorPaletteForBackground = 0
    view.Background = [1, 1, 1]
    view.OrientationAxesVisibility = 1
    parts = {path.name.split(".")[0]: opened(path.name.split(".")[0], path.resolve())
             for path in found}
    sources = {name: source for name, (source, _) in parts.items()}
    scene = simple.GetAnimationScene()
    scene.UpdateAnimationUsingDataTimeSteps()
    times, now = instant(sources, time)
    if now is not None:
        scene.AnimationTime = view.ViewTime = now
    for name, (_, drawn) in parts.items():
        show(name, drawn, view, name == INSIDE and "stones" in parts)
    # The train may be much longer than the bed.
    look_at(sources.get("stones") or sources.get("ground") or next(iter(sources.values())), view)
    simple.SaveState(str(state))
    if picture:
        simple.SaveScreenshot(str(picture), view, ImageResolution=SIZE)
    print(f"{state}: {', '.join(sources)}; {len(times)} times"
          + (f" from {times[0]:g} to {times[-1]:g} s; drawn: {now:g} s" if times else ""))


if __name__ == "__main__":
    if len(sys.argv) not in (3, 4, 5):
        sys.exit(__doc__)
    main(*sys.argv[1:4], *map(float, sys.argv[4:]))
