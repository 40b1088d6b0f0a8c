"""The model in space, drawn with VTK without a screen: parts of one instant in one picture.

One part is coloured by an array, the others have plain colours. All pictures of a Scene have the
same camera and the same range of colours.
"""
import os
import shutil
import subprocess
import sys
import tempfile

from trackbed_post import actors, read

SIZE = (1200, 500)  # pixels
BAR = 180           # pixels at the right edge, for the colour bar
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
    """Parallel projection that shows all of a box, with space for the colour bar on the right."""
    import numpy as np
    low, high = box
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


def black(text):
    text.SetColor(0, 0, 0)
    text.ShadowOff()
    text.ItalicOff()
    text.BoldOff()


def colour_bar(colouring):
    import vtk
    bar = vtk.vtkScalarBarActor()
    bar.SetLookupTable(actors.colour_table(colouring.limits))
    bar.SetTitle(colouring.title())
    bar.SetMaximumHeightInPixels(SIZE[1] // 2)
    bar.SetVerticalTitleSeparation(12)  # pixels
    bar.SetLabelFormat("%.3g")
    black(bar.GetTitleTextProperty())
    black(bar.GetLabelTextProperty())
    return bar


class Scene:
    """A window without a screen that shows what a grids.Survey has seen, or its section between two
    x, m (`along`)."""

    def __init__(self, survey, colouring, view, along=None):
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
        self.window.SetSize(*SIZE)
        self.window.SetMultiSamples(0)  # no mixed colours at edges, so that they can be counted
        self.window.AddRenderer(self.renderer)
        self.renderer.SetBackground(1, 1, 1)
        self.bar, self.label, self.actors = colour_bar(colouring), vtk.vtkTextActor(), []
        black(self.label.GetTextProperty())
        self.label.GetTextProperty().SetFontSize(18)
        self.label.SetPosition(10, 10)
        look(self.renderer.GetActiveCamera(), box, *VIEWS[view])

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
        """Pixels with colour bar and label, [height, width, 3]."""
        self.label.SetInput(label)
        self.renderer.AddActor2D(self.bar)
        self.renderer.AddActor2D(self.label)
        return self._pixels()

    def colours(self):
        """Number of colours of the model, without shades."""
        import numpy as np
        self.renderer.RemoveActor2D(self.bar)
        self.renderer.RemoveActor2D(self.label)
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
        return flat.reshape(SIZE[1], SIZE[0], -1)[::-1].copy()  # rows from the top
