"""All fields of a run in ParaView, as they are meant to be seen: stones and sleepers in their
shapes, balls as spheres, contact forces as tubes, ground, rail and wheels, with the times of the
run.

    pvbatch postproc/paraview/view.py RESULT_DIR VIEW.pvsm [PICTURE.png [TIME]] [OPTIONS]

writes a state file, which ParaView opens (File > Load State), and a picture of the instant at TIME
(s), by default of that at which a wheel is nearest to the middle of the bed, or of the last one.
The picture shows the bed below this wheel, several sleepers long, and a plane model from the side.
Colours have the range of what the picture shows, those of speeds without the fastest 1 %. Ground
and solids are drawn displaced, as stones touch them.
Without a screen: `xvfb-run -a pvbatch ...`.
"""
import argparse
import contextlib
import pathlib
import sys

import numpy as np
from paraview import servermanager, simple

# The file alone: ParaView and h5py, which the package needs, may bring different HDF5 libraries.
sys.path.append(str(pathlib.Path(__file__).resolve().parents[1] / "trackbed_post"))
from framing import (CORNER, LONG, MOST, SIDE, UP, camera, depth_limited,  # noqa: E402
                     highest_speed, joined, passing, window)

ABOVE_RAIL = 0.05       # m, shown above the lowest point of the rail if there is no wheel
ABOVE_BED = 0.3         # m, above the stones without a rail: sleepers are less high, walls higher
BLACK, GREY, STEEL = [0.0, 0.0, 0.0], [0.62, 0.6, 0.57], [0.25, 0.27, 0.3]
PALE, BROWN, BLUE = [0.75, 0.74, 0.72], [0.55, 0.34, 0.29], [0.72, 0.77, 0.82]
WHOLE = ("stones", "contacts", "bonds")  # not cut at the ends of the picture
FAR = 1e5               # m, beyond every model
EVERYWHERE = np.array([[-FAR] * 3, [FAR] * 3])
TITLE, LABEL = 22, 18   # points, of axes and colour bars
AXES_OF_PLANE, AXES_OF_SPACE = 5, 7  # edges with labels: sums of 1, 2, 4 for least x, y, z
# Part -> kind of data, array and title of its colours; of vectors the magnitude is shown.
COLOURED_BY = {"stones": ("CELLS", "velocity", "speed (m/s)"),
               "ground": ("POINTS", "displacement", "displacement of the ground (m)"),
               "contacts": ("POINTS", "force_size", "contact force (N)"),
               "solids": ("POINTS", "displacement", "displacement of the solids (m)")}
AT_REST = ("ground", "solids")  # their files have the undisplaced points
# Limits of the array `part` of surfaces; not 0, which ParaView 5.11 takes as a value not given.
WALLS, SLEEPERS = (-0.5, 0.5), (1.5, 2.5)
BODIES = {"plates and boxes": (0.5, 1.5), "platen and tines": (2.5, 4.5)}
TO_CENTRES = "to_centre"  # of the ends of contacts: vector to the stone's centre of mass, m
THICK = 0.004             # of a picture's length up to LONG: radius of the largest force's tube
OPACITIES = {True: 0.7, False: 0.1}  # of stones around contact forces: in a plane, in space
SHORTEST = 2.0            # radii of this tube: shorter lines are drawn as spheres


def options(words):
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=pathlib.Path, metavar="RESULT_DIR")
    parser.add_argument("state", metavar="VIEW.pvsm")
    parser.add_argument("picture", nargs="?", metavar="PICTURE.png")
    parser.add_argument("time", nargs="?", type=float, metavar="TIME")
    parser.add_argument("--whole", action="store_true", help="show the whole bed")
    parser.add_argument("--x", nargs=2, type=float, metavar=("FROM", "TO"),
                        help="show what is between two places along the track, m")
    parser.add_argument("--parts", help="draw these only, with commas between them; with contacts, "
                        "stones are transparent, without them coloured by their speed; default: "
                        "all, contacts only of plane models")
    given = parser.parse_args(words)
    if given.x and not given.x[0] < given.x[1]:
        parser.error(f"--x {given.x[0]:g} {given.x[1]:g}: the second number must be the larger one")
    return given


# What is drawn of each part.

def update(source, now):
    """Reads the data of a time, s; None: those of no or any time."""
    if now is None:
        source.UpdatePipeline()
    else:
        source.UpdatePipeline(now)


def flat(stones):
    """Whether all stones are in a plane along the track."""
    bounds = stones.GetDataInformation().GetBounds()
    return bounds[3] - bounds[2] < 1e-6 < bounds[1] - bounds[0]


def box_of(source, now):
    """[lowest, highest] corner of the data of a time; None if there are none."""
    update(source, now)
    bounds = source.GetDataInformation().GetBounds()
    return None if bounds[0] > bounds[1] else np.array([bounds[::2], bounds[1::2]])


def colour(display, part, view, shared=False):
    """Colours a display by the array of its part, with a bar and a range of its own, or with those
    of the array."""
    place, array, title = COLOURED_BY[part]
    own = not shared
    display.UseSeparateColorMap = own
    simple.ColorBy(display, (place, array) if part == "contacts" else (place, array, "Magnitude"),
                   separate=own)
    display.RescaleTransferFunctionToDataRange(False, True)
    table = simple.GetColorTransferFunction(array, display, separate=own)
    table.ApplyPreset("Viridis (matplotlib)", True)
    if part == "contacts":  # the largest are dark, before the pale stones
        table.InvertTransferFunction()
    bar = simple.GetScalarBar(table, view)
    bar.Title, bar.ComponentTitle = title, ""
    bar.TitleColor = bar.LabelColor = BLACK
    bar.TitleFontSize, bar.LabelFontSize = TITLE, LABEL
    bar.RangeLabelFormat = bar.LabelFormat = "%-#.3g"
    bar.DrawTickLabels = 0  # those of small numbers would lie over each other
    display.SetScalarBarVisibility(view, True)
    return bar


def plain(source, view, rgb, opacity=1.0):
    """A display of one colour."""
    display = simple.Show(source, view)
    display.Representation = "Surface"
    display.ColorArrayName = ["POINTS", ""]
    display.DiffuseColor = display.AmbientColor = rgb
    display.Opacity = opacity
    return display


def opened(part, path):
    """The series of one part, displaced if its points are not."""
    source = simple.VTKHDFReader(registrationName=part, FileName=[str(path)])
    source.UpdatePipeline()
    if part not in AT_REST:
        return source, source
    moved = simple.WarpByVector(registrationName=f"{part} displaced", Input=source,
                                Vectors=["POINTS", "displacement"], ScaleFactor=1.0)
    return source, moved


def balls_of(stones):
    """Points with a radius as spheres; None if there are none."""
    alone = simple.ExtractCellsByType(registrationName="balls", Input=stones,
                                      CellTypes=["Vertex", "Poly Vertex"])
    alone.UpdatePipeline()
    if alone.GetDataInformation().GetNumberOfCells() == 0:
        simple.Delete(alone)
        return None
    # The velocity of cells is given to their points, which carry the spheres.
    points = simple.CellDatatoPointData(registrationName="ball values", Input=alone)
    return simple.Glyph(registrationName="spheres", Input=points, GlyphType="Sphere",
                        ScaleArray=["POINTS", "radius"], ScaleFactor=2.0, GlyphMode="All Points")


def limit_speeds(stones, bar):
    """Lets the colours end at the speed of all but a few stones, which rattle, and says so; unless
    all but these are at rest."""
    from vtkmodules.util.numpy_support import vtk_to_numpy
    cells = servermanager.Fetch(stones).GetCellData()
    arrays = [cells.GetArray(name) for name in ("velocity", "stone")]
    if any(array is None for array in arrays):
        return
    if (highest := highest_speed(*map(vtk_to_numpy, arrays))) > 0:
        simple.GetColorTransferFunction("velocity").RescaleTransferFunction(0.0, highest)
        bar.Title = f"{bar.Title}, fastest {100 - MOST} % beyond the bar"


def show_stones(stones, view, opacity):
    """Stones coloured by their speed, or pale and transparent around contact forces; `opacity` or
    None."""
    bars = []
    for source, place in ((stones, "CELLS"), (balls_of(stones), "POINTS")):
        if source is None:
            continue
        display = plain(source, view, PALE, opacity or 1.0)
        if opacity is None and place == "CELLS":
            bars.append(colour(display, "stones", view, shared=True))
            limit_speeds(source, bars[-1])
        elif opacity is None:
            simple.ColorBy(display, (place, "velocity", "Magnitude"))
    return bars


def show_surfaces(surfaces, view, with_sleepers):
    """Walls as edges, sleepers and other bodies transparent: stones are behind them."""
    def chosen(name, limits):
        return simple.Threshold(registrationName=name, Input=surfaces, Scalars=["CELLS", "part"],
                                LowerThreshold=limits[0], UpperThreshold=limits[1])
    faces = simple.ExtractSurface(registrationName="wall faces", Input=chosen("walls", WALLS))
    edges = simple.FeatureEdges(registrationName="wall edges", Input=faces)
    plain(edges, view, GREY).LineWidth = 2
    if with_sleepers:
        plain(chosen("sleepers", SLEEPERS), view, BROWN, 0.4)
    for name, limits in BODIES.items():
        plain(chosen(name, limits), view, BLUE, 0.5)


def lengths(contacts):
    """Of the lines of contacts, m."""
    from vtkmodules.util.numpy_support import vtk_to_numpy
    points = vtk_to_numpy(servermanager.Fetch(contacts).GetPoints().GetData()).reshape(-1, 2, 3)
    return np.linalg.norm(points[:, 1] - points[:, 0], axis=1)


def as_spheres(contacts, factor):
    """At the middle of the lines; their radius is twice the `factor` times the force."""
    centres = simple.CellCenters(registrationName="contact places", Input=contacts)
    return simple.Glyph(registrationName="contact forces", Input=centres, GlyphType="Sphere",
                        ScaleArray=["POINTS", "force_size"], ScaleFactor=4 * factor,
                        GlyphMode="All Points")


def as_tubes(contacts, factor):
    """Along the lines; their radius is the `factor` times the force."""
    values = simple.CellDatatoPointData(registrationName="contact values", Input=contacts)
    lines = simple.ExtractSurface(registrationName="contact lines", Input=values)
    radii = simple.Calculator(registrationName="radii", Input=lines, ResultArrayName="radius",
                              Function=f"force_size*{factor:.9g}")
    return simple.Tube(registrationName="contact forces", Input=radii, Capping=1, Radius=1,
                       Scalars=["POINTS", "radius"], VaryRadius="By Absolute Scalar",
                       NumberofSides=10)


def show_contacts(contacts, view, length, now, visible):
    """Contact forces in a picture of this length, m: tubes between the centres of the stones if
    the file has them, else between the pieces, or spheres where these are too close."""
    source = contacts
    if TO_CENTRES in contacts.PointData.keys():
        source = simple.WarpByVector(registrationName="branches", Input=contacts, ScaleFactor=1.0,
                                     Vectors=["POINTS", TO_CENTRES])
    force = contacts.CellData["force_size"]
    largest = force.GetRange()[1] if force else 0
    if largest <= 0:
        return []
    radius = THICK * np.sqrt(length * min(length, LONG))
    update(source, now)
    if np.median(lengths(source)) < SHORTEST * radius:
        drawn = as_spheres(source, radius / largest)
    else:
        drawn = as_tubes(source, radius / largest)
    display = plain(drawn, view, BLACK)
    bar = colour(display, "contacts", view)
    if not visible:
        display.SetScalarBarVisibility(view, False)
        simple.Hide(drawn, view)
    return [bar] if visible else []


def show_axes(view, box, plane):
    """Axes with names and units around a box."""
    axes = view.AxesGrid
    axes.Visibility = 1
    axes.UseCustomBounds, axes.CustomBounds = 1, [float(x) for x in box.T.ravel()]
    for axis, title in (("X", "x along the track (m)"), ("Y", "y across (m)"), ("Z", "z (m)")):
        title = title if axis == "X" else f"{title:^{len(title) + 16}}"  # beside the labels
        for name, value in (("Title", title), ("TitleFontSize", TITLE), ("LabelFontSize", LABEL),
                            ("TitleColor", BLACK), ("LabelColor", BLACK)):
            setattr(axes, f"{axis}{name}", value)
    axes.GridColor = GREY
    axes.ShowGrid = 0
    axes.AxesToLabel = AXES_OF_PLANE if plane else AXES_OF_SPACE
    if plane:
        axes.YTitle = ""
        axes.YAxisUseCustomLabels, axes.YAxisLabels = 1, []


def wheels_at(train, time):
    """x of the wheels, m, at an instant."""
    train.UpdatePipeline(time)
    grid = servermanager.Fetch(train)
    number = grid.GetCellData().GetArray("wheel")
    return [sum(grid.GetCell(k).GetBounds()[:2]) / 2 for k in range(grid.GetNumberOfCells())
            if number.GetTuple1(k) >= 0]


def instant(sources, train, given, bed):
    """(all times, that of the files nearest to the given one, x of the wheel to look at). Without
    a given time that at which a wheel is nearest to the middle of the bed, else the last one."""
    times = sorted({time for one in sources.values() for time in (one.TimestepValues or [])})
    if not times:
        return times, None, None
    require_time(times, given)
    candidates = list(train.TimestepValues or []) if train else []
    if given is not None:
        now = min(times, key=lambda time: abs(time - given))
        candidates = [now] if now in candidates else []
    found = passing([(time, wheels_at(train, time)) for time in candidates], *bed)
    return times, *(found or (times[-1] if given is None else now, None))


def model_box(parts, now, with_wheel):
    """The box of the bed with the rail, or with the sleepers if there is none, and, if asked, its
    wheels, without what is deep in the ground; the whole model if there is no bed."""
    boxes = {name: box for name, (_, drawn) in parts.items()
             if (box := box_of(drawn, now)) is not None}
    bed = [boxes[name] for name in ("stones", "solids") if name in boxes] or \
        [boxes[name] for name in boxes if name not in ("train", "ground")] or list(boxes.values())
    found = joined(bed)
    if "train" in boxes:  # only in height; the rail is the lowest of the train
        top = boxes["train"][1][2] if with_wheel else boxes["train"][0][2] + ABOVE_RAIL
        found[1][2] = max(found[1][2], top)
    elif "surfaces" in boxes:
        found[1][2] = max(found[1][2], min(boxes["surfaces"][1][2], found[1][2] + ABOVE_BED))
    return depth_limited(found, boxes["ground"]) if "ground" in boxes else found


def set_box(clip, box):
    clip.ClipType.Position = [float(x) for x in box[0]]
    clip.ClipType.Length = [float(x) for x in box[1] - box[0]]


def clipped(parts, seen):
    """Part -> what is drawn of it within a box, so that nothing is behind labels. Stones and
    contacts are kept whole."""
    wide = seen + np.array([[-1e-6] * 3, [1e-6] * 3])
    wide[:, 1] = -FAR, FAR
    clips = {}
    for name, (_, drawn) in parts.items():
        clips[name] = simple.Clip(registrationName=f"{name} in the window", Input=drawn,
                                  ClipType="Box", Invert=1,
                                  Exact=int(name not in WHOLE), Crinkleclip=int(name in WHOLE))
        set_box(clips[name], wide)
    return clips


def show_all(parts, view, length, now, opacity):
    """Draws the parts, contacts only with an opacity of the stones, which hide them without it.
    Returns the colour bars."""
    bars = []
    for name, drawn in parts.items():
        update(drawn, now)
        if name == "stones":
            bars += show_stones(drawn, view, opacity)
        elif name == "contacts":
            bars += show_contacts(drawn, view, length, now, opacity is not None)
        elif name == "surfaces":
            show_surfaces(drawn, view, "solids" not in parts)  # the same faces twice would flicker
        elif name in COLOURED_BY:
            display = plain(drawn, view, GREY)
            if name == "solids" and opacity is not None:
                display.Opacity = 0.5
            bars.append(colour(display, name, view))
        else:
            plain(drawn, view, STEEL).LineWidth = 4
    return bars


def place_bars(bars, pixels):
    """Colour bars side by side at the top of a picture of so many pixels."""
    for k, bar in enumerate(bars):
        bar.WindowLocation, bar.Orientation = "Any Location", "Horizontal"
        bar.ScalarBarLength = 0.8 / max(len(bars), 2) - 0.06
        bar.Position = [0.18 + 0.8 * k / max(len(bars), 2), 1 - 90 / pixels]


def show_time(view, source):
    """The time of the run in the upper left corner."""
    shown = simple.Show(simple.AnnotateTimeFilter(registrationName="time", Input=source,
                                                  Format="time {time:.4f} s"), view)
    shown.Color, shown.FontSize = BLACK, TITLE
    shown.WindowLocation = "Upper Left Corner"


def new_view():
    simple._DisableFirstRenderCameraReset()
    view = simple.CreateRenderView()
    view.UseColorPaletteForBackground = 0
    view.Background = [1, 1, 1]
    view.OrientationAxesVisibility = 0  # the axes around the model have names and units
    view.CameraParallelProjection = 1
    return view


def found_parts(folder, chosen):
    """Part -> (its series, what is drawn of it)."""
    fields = folder / "fields"
    found = {path.name.split(".")[0]: path for path in sorted(fields.glob("*.hdf.series"))}
    if not found:
        sys.exit(f"{fields} contains no fields: run the deck with output.fields=true")
    names = chosen.split(",") if chosen else list(found)
    if missing := [name for name in names if name not in found]:
        sys.exit(f"{fields} has no {', '.join(missing)}, but {', '.join(found)}")
    return {name: opened(name, found[name].resolve()) for name in names}


@contextlib.contextmanager
def part_of(folder, name, parts):
    """What is drawn of a part, also of one that is not chosen; None if the run has none."""
    path = folder / "fields" / f"{name}.hdf.series"
    if name in parts or not path.exists():
        yield parts[name][1] if name in parts else None
        return
    source, drawn = opened(name, path.resolve())
    yield drawn
    simple.Delete(drawn)
    if source is not drawn:
        simple.Delete(source)


def is_plane(folder, parts):
    """Whether all stones of the run, or all contacts, are in a plane along the track."""
    for name in ("stones", "contacts"):
        with part_of(folder, name, parts) as drawn:
            if drawn is not None and drawn.GetDataInformation().GetNumberOfCells():
                return flat(drawn)
    return False


def require_time(times, time):
    """Ends with a message if no file is near a time, s."""
    if not times or time is None:
        return
    gap = max(np.diff(times), default=0.0)
    if not times[0] - gap <= time <= times[-1] + gap:
        sys.exit(f"there are no fields near {time:g} s, but from {times[0]:g} to {times[-1]:g} s")


def main(words):
    given = options(words)
    parts = found_parts(given.folder, given.parts)
    sources = {name: source for name, (source, _) in parts.items()}
    scene = simple.GetAnimationScene()
    scene.UpdateAnimationUsingDataTimeSteps()
    with part_of(given.folder, "train", parts) as train:
        times, now, wheel = instant(sources, train, given.time,
                                    model_box(parts, None, False)[:, 0])
    whole = model_box(parts, now, wheel is not None)
    plane = is_plane(given.folder, parts)
    eye = SIDE if plane else CORNER
    seen = whole if given.whole else window(whole, wheel, eye)
    if given.x:
        if given.x[1] <= whole[0][0] or given.x[0] >= whole[1][0]:
            sys.exit(f"--x {given.x[0]:g} {given.x[1]:g}: the model reaches from "
                     f"{whole[0][0]:.4g} to {whole[1][0]:.4g} m")
        seen[:, 0] = given.x
    view = new_view()  # after all checks: ParaView 5.11 crashes at an exit with a view
    if now is not None:
        scene.AnimationTime = view.ViewTime = now
    focus, position, scale, size = camera(seen, eye)
    clips = clipped(parts, seen)
    forces = "contacts" in parts and (plane or given.parts)
    opacity = OPACITIES[plane] if forces else None
    place_bars(show_all(clips, view, seen[1][0] - seen[0][0], now, opacity), size[1])
    show_axes(view, seen, plane)
    if times:
        show_time(view, next(iter(sources.values())))
    view.ViewSize = size
    view.CameraFocalPoint, view.CameraPosition = list(focus), list(position)
    view.CameraViewUp, view.CameraParallelScale = list(UP), scale
    if given.picture:
        simple.SaveScreenshot(str(given.picture), view, ImageResolution=size)
    for clip in clips.values():  # the state shows all
        set_box(clip, EVERYWHERE)
    simple.SaveState(str(given.state))
    print(f"{given.state}: {', '.join(sources)}; {len(times)} times"
          + (f" from {times[0]:g} to {times[-1]:g} s; drawn: {now:g} s" if times else ""))


if __name__ == "__main__":
    main(sys.argv[1:])
