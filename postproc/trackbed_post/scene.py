"""The model in space, drawn with VTK without a screen: parts of one instant in one picture.

One part is coloured by an array, the others have plain colours. All pictures of a Scene have the
same camera and the same range of colours. A picture is as wide and as high as the model needs; the
colour bar is at its right edge, instant and origin are below.
"""
import os
import shutil
import subprocess
import sys
import tempfile

from trackbed_post import actors, framing, read

BAR = 220                      # pixels at the right edge, for the colour bar
BAR_LONG, BAR_WIDE = 300, 180  # pixels, of the bar with its title at most
FRAME = framing.Frame(800, 1600, 300, 800, 20, BAR, 95, 20)
TITLE, LABEL, ORIGIN = 17, 18, 12  # heights of letters, pixels
ORIGIN_HIGH = 40               # pixels at the lower edge, for the two lines that state the origin
# Direction from the model to the eye, and the one that points up in the picture.
VIEWS = {"side": ((0, -1, 0), (0, 0, 1)), "end": ((-1, 0, 0), (0, 0, 1)),
         "top": ((0, 0, 1), (0, 1, 0)), "corner": ((-1, -2, 1), (0, 0, 1))}
VIEW = "side"  # unless another is given


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


def look(camera, box, eye, up):
    """Parallel projection that shows all of a box; the size of its picture, pixels."""
    import numpy as np
    focus, position, half, size = framing.camera(np.array(box), eye, up, FRAME)
    camera.ParallelProjectionOn()
    camera.SetParallelScale(half)
    camera.SetFocalPoint(*focus)
    camera.SetPosition(*position)
    camera.SetViewUp(*up)
    return size


def black(text):
    text.SetColor(0, 0, 0)
    text.ShadowOff()
    text.ItalicOff()
    text.BoldOff()


def colour_bar(colouring, size):
    """At the right edge of a picture of this size, pixels."""
    import vtk
    wide, high = size
    long = min(BAR_LONG, high - ORIGIN_HIGH - 40)
    below = ORIGIN_HIGH + (high - ORIGIN_HIGH - long) / 2
    bar = vtk.vtkScalarBarActor()
    bar.SetLookupTable(actors.colour_table(colouring.limits))
    bar.SetTitle(colouring.title())
    bar.UnconstrainedFontSizeOn()
    bar.SetPosition(1 - (BAR - 20) / wide, below / high)
    bar.SetPosition2(BAR_WIDE / wide, long / high)
    bar.SetVerticalTitleSeparation(12)  # pixels
    bar.SetLabelFormat("%.3g")
    for text in (bar.GetTitleTextProperty(), bar.GetLabelTextProperty()):
        black(text)
        text.SetFontSize(TITLE)
    return bar


def text_at(x, y, height):
    """An empty text whose lower left corner is at a place in the picture, pixels."""
    import vtk
    text = vtk.vtkTextActor()
    black(text.GetTextProperty())
    text.GetTextProperty().SetFontSize(height)
    text.GetTextProperty().SetLineSpacing(1.2)
    text.SetPosition(x, y)
    return text


class Scene:
    """A window without a screen that shows what a grids.Survey has seen, or its section between two
    x, m (`along`). `origin`: of which run it is, in the lower right corner."""

    def __init__(self, survey, colouring, view, along=None, origin=""):
        import vtk
        box = survey.box()
        if along:
            if along[0] >= box[1][0] or along[1] <= box[0][0]:
                raise read.Unreadable(f"nothing is between x = {along[0]:g} and {along[1]:g} m: "
                                      f"the parts are from {box[0][0]:.4g} to {box[1][0]:.4g} m")
            for corner, x in zip(box, along):
                corner[0] = x
        self.cuts = [actors.cut(x, normal) for x, normal in zip(along or (), (1, -1))]
        self.colouring, self.ends = colouring, (box[0][0], box[1][0])
        self.together = len(survey.boxes) > 1  # also where an instant has one of the parts only
        self.renderer, self.window = vtk.vtkRenderer(), vtk.vtkRenderWindow()
        self.window.SetOffScreenRendering(1)
        self.size = look(self.renderer.GetActiveCamera(), box, *VIEWS[view])
        self.window.SetSize(*self.size)
        self.window.SetMultiSamples(0)  # no mixed colours at edges, so that they can be counted
        self.window.AddRenderer(self.renderer)
        self.renderer.SetBackground(1, 1, 1)
        self.bar, self.actors = colour_bar(colouring, self.size), []
        self.label = text_at(10, ORIGIN_HIGH + 2, LABEL)
        self.origin = text_at(self.size[0] - 8, 6, ORIGIN)
        self.origin.GetTextProperty().SetJustificationToRight()
        self.origin.GetTextProperty().SetColor(0.4, 0.4, 0.4)
        self.origin.SetInput(origin.replace("$", r"\$"))  # no formula

    def show(self, grids):
        """Replaces what is shown by the grids of an instant."""
        for actor in self.actors:
            self.renderer.RemoveActor(actor)
        self.actors = []
        for part, grid in grids.items():
            mine = self.colouring if part == self.colouring.part and self.colouring.array(grid) \
                else None
            pieces = actors.pieces_of(part, grid, self.ends, grids) if self.together else \
                [(part, grid)]
            for name, piece in pieces:
                piece, cuts = actors.section(piece, self.cuts)
                self.actors += actors.actors_of(name, piece, mine, cuts)
        for actor in self.actors:
            self.renderer.AddActor(actor)
        self.renderer.ResetCameraClippingRange()

    def picture(self, label=""):
        """Pixels with colour bar, label and origin, [height, width, 3]."""
        self.label.SetInput("\n".join(filter(None, (label, self.colouring.beyond))))
        for one in (self.bar, self.label, self.origin):
            self.renderer.AddActor2D(one)
        return self._pixels()

    def colours(self):
        """Number of colours of the model, without shades."""
        import numpy as np
        for one in (self.bar, self.label, self.origin):
            self.renderer.RemoveActor2D(one)
        shaded = [actor for actor in self.actors if actor.GetProperty().GetLighting()]
        for actor in shaded:
            actor.GetProperty().LightingOff()
        colours = np.unique(self._pixels().astype(np.int64) @ [1 << 16, 1 << 8, 1])
        for actor in shaded:
            actor.GetProperty().LightingOn()
        return np.count_nonzero(colours != 0xFFFFFF)  # white is the background

    def _pixels(self):
        from vtk.util.numpy_support import vtk_to_numpy
        import vtk
        self.window.Render()
        grabbed = vtk.vtkWindowToImageFilter()
        grabbed.SetInput(self.window)
        grabbed.ReadFrontBufferOff()
        grabbed.Update()
        flat = vtk_to_numpy(grabbed.GetOutput().GetPointData().GetScalars())
        return flat.reshape(self.size[1], self.size[0], -1)[::-1].copy()  # rows from the top
