"""Files of films, GIF or MP4, from pictures: arrays [height, width, 3] of bytes."""
import io
import itertools
import pathlib
import shutil
import subprocess
import tempfile

import numpy as np
from PIL import Image

from trackbed_post import read

FRAME_MS = 120  # each picture is shown
EVEN = 0.1      # relative, by which steps of time may differ from the median
FEW = 0.1       # of the steps, which may differ by more: those at the ends of stages


def pace(times):
    """Words that state how much slower the film of these instants, s, is than what it shows; of
    one instant nothing."""
    steps = np.diff(times)
    if not len(steps):
        return ""
    step = np.median(steps)
    if step <= 0 or np.mean(np.abs(steps - step) > EVEN * step) > FEW:
        return f"a picture every {FRAME_MS} ms, at uneven times"
    slower = FRAME_MS / 1e3 / step
    if abs(slower - 1) < EVEN:
        return "as fast as in reality"
    return f"{slower:.2g} times slower than in reality" if slower > 1 else \
        f"{1 / slower:.2g} times faster than in reality"


def require_name(path):
    """The kind of a film follows from the end of its name."""
    path = pathlib.Path(path)
    if path.suffix not in (".gif", ".mp4"):
        raise read.Unreadable(f"{path}: the name of the film must end in .gif or .mp4")
    if path.suffix == ".mp4" and not shutil.which("ffmpeg"):
        raise read.Unreadable(f"{path}: MP4 files are written by ffmpeg, which is not on PATH: "
                              "install it (Debian package ffmpeg), or give a name that ends in "
                              ".gif")


def encoded(path, pictures):
    """Bytes of the file of this name."""
    return (mp4 if pathlib.Path(path).suffix == ".mp4" else gif)(pictures)


def gif(pictures):
    """Bytes of a GIF file."""
    frames = (Image.fromarray(pixels).quantize(255, dither=Image.Dither.NONE)
              for pixels in pictures)
    file = io.BytesIO()
    next(frames).save(file, format="GIF", save_all=True, append_images=frames, loop=0,
                      duration=FRAME_MS)
    return file.getvalue()


def mp4(pictures):
    """Bytes of an MP4 file, encoded as players of the web expect it: sides of even length."""
    pictures = iter(pictures)
    first = next(pictures)
    high, wide = first.shape[:2]
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "film.mp4"
        with subprocess.Popen(
                ["ffmpeg", "-loglevel", "error", "-f", "rawvideo", "-pix_fmt", "rgb24", "-s",
                 f"{wide}x{high}", "-r", f"{1000 / FRAME_MS:.6g}", "-i", "-",
                 "-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2:color=white", "-pix_fmt", "yuv420p",
                 str(path)],
                stdin=subprocess.PIPE, stderr=subprocess.PIPE) as encoder:
            try:
                for pixels in itertools.chain([first], pictures):
                    encoder.stdin.write(pixels.tobytes())
            except BrokenPipeError:
                pass  # it has ended, and states why
            why = encoder.communicate()[1].decode(errors="replace").strip()
        if encoder.returncode or not path.is_file():
            raise read.Unreadable(f"ffmpeg has written no film: {why or encoder.returncode}")
        return path.read_bytes()
