"""A film of the field files of a run, drawn by scene.py: a picture for each instant.

The files are read twice: first for the box around all parts and the range of colours over all
instants, which every picture has, then to draw them. A GIF is kept in memory as pictures of 255
colours, an MP4 file is written by ffmpeg as it is drawn.
"""
import io
import pathlib
import shutil
import subprocess
import tempfile

from PIL import Image

from trackbed_post import grids, instants, read, scene, still, write

FRAME_MS = 120  # each picture is shown
FRAMES = 200    # at most, unless another number is given


def require_name(path):
    """The kind of a film follows from the end of its name."""
    path = pathlib.Path(path)
    if path.suffix not in (".gif", ".mp4"):
        raise read.Unreadable(f"{path}: the name of the film must end in .gif or .mp4")
    if path.suffix == ".mp4" and not shutil.which("ffmpeg"):
        raise read.Unreadable(f"{path}: MP4 files are written by ffmpeg, which is not on PATH: "
                              "install it (Debian package ffmpeg), or give a name that ends in "
                              ".gif")


def gif(pictures):
    """Bytes of a GIF file."""
    frames = (Image.fromarray(pixels).convert("P", palette=Image.Palette.ADAPTIVE, colors=255)
              for pixels in pictures)
    file = io.BytesIO()
    next(frames).save(file, format="GIF", save_all=True, append_images=frames, loop=0,
                      duration=FRAME_MS)
    return file.getvalue()


def mp4(pictures):
    """Bytes of an MP4 file, encoded as players of the web expect it."""
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "film.mp4"
        with subprocess.Popen(
                ["ffmpeg", "-loglevel", "error", "-f", "rawvideo", "-pix_fmt", "rgb24", "-s",
                 "{}x{}".format(*scene.SIZE), "-r", f"{1000 / FRAME_MS:.6g}", "-i", "-",
                 "-pix_fmt", "yuv420p", str(path)],
                stdin=subprocess.PIPE, stderr=subprocess.PIPE) as encoder:
            try:
                for pixels in pictures:
                    encoder.stdin.write(pixels.tobytes())
            except BrokenPipeError:
                pass  # it has ended, and states why
            why = encoder.communicate()[1].decode(errors="replace").strip()
        if encoder.returncode or not path.is_file():
            raise read.Unreadable(f"ffmpeg has written no film: {why or encoder.returncode}")
        return path.read_bytes()


def survey_of(shots, parts):
    """The grids.Survey over all instants."""
    files = {part: path for shot in shots for part, path in shot.files.items()}
    survey = grids.Survey(still.first_part(files, parts))
    for shot in shots:
        survey.add(shot.files)
    if not survey.boxes:
        raise read.Unreadable("the field files have no cells: choose other --parts, another "
                              "--stage or --time")
    return survey


def pictures(shots, window):
    for shot in shots:
        window.show(grids.read_grids(shot.files))
        yield window.picture(shot.label())


def film(folder, path, choices, remark=""):
    """Writes the film of a run. `choices`: array, view, parts, stage, time, limits, x, frames;
    `remark`: why it is not another film."""
    require_name(path)
    found = instants.within(instants.of_run(folder, choices.parts), choices.stage, choices.time)
    shots = instants.thinned(found, choices.frames or FRAMES)
    write.folder(pathlib.Path(path).resolve().parent)
    scene.with_screen()
    if remark:
        print(remark)
    survey = survey_of(shots, choices.parts)
    colouring = survey.colouring(choices.array, choices.limits)
    few = f" of {len(found)}" if len(shots) < len(found) else ""
    print(f"{len(shots)}{few} instants from {shots[0].time:.6g} to {shots[-1].time:.6g} s: "
          f"{', '.join(survey.boxes)}; {colouring.part} coloured by {colouring.words()}",
          flush=True)
    drawn = pictures(shots, scene.Scene(survey, colouring, choices.view or scene.VIEW,
                                        choices.x))
    content = (mp4 if pathlib.Path(path).suffix == ".mp4" else gif)(drawn)
    write.whole(path, content)
    print(f"{path}: {len(content) / 1e6:.1f} MB")
