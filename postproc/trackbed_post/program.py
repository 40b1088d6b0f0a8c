"""The program trackbed: where it is, and the drawing of a deck's model that it makes."""
import functools
import os
import pathlib
import shutil
import subprocess
import tempfile

from trackbed_post import read

PATIENCE = 60  # s for a drawing; a deck with a large cell or mesh is read in less
WITHOUT = ("bed.cell=", "start=")  # states of other runs, which may be gone; they are not drawn


def find(given: pathlib.Path | None = None) -> pathlib.Path:
    """The program: as given, or built beside this package, or on the PATH."""
    built = pathlib.Path(__file__).resolve().parents[2] / "build/release/trackbed"
    installed = shutil.which("trackbed")
    found = str(given or (built if built.is_file() else installed or ""))
    if not found or not os.path.isfile(found) or not os.access(found, os.X_OK):
        raise read.Unreadable(f"{found} is not a program; give another --program" if found else
                              "trackbed was not found (build/release, PATH): give --program")
    return pathlib.Path(found).resolve()


@functools.lru_cache(maxsize=32)  # a report of a running run is written many times
def drawing(deck: str, given: pathlib.Path | None = None) -> str:
    """The model of a deck (its text), seen from the side, as SVG: `trackbed check --draw`."""
    try:
        program = find(given)
    except read.Unreadable as why:
        raise read.Unreadable(f"the model was not drawn: {why}") from None
    with tempfile.TemporaryDirectory() as folder:
        picture, problem = pathlib.Path(folder) / "model.svg", ""
        (pathlib.Path(folder) / "deck.toml").write_text(deck, encoding="utf-8")
        for changes in ((), WITHOUT):
            try:
                ran = subprocess.run([str(program), "check", "deck.toml", *changes, "--draw",
                                      picture.name], cwd=folder, capture_output=True, text=True,
                                     check=False, timeout=PATIENCE)
            except (OSError, subprocess.TimeoutExpired) as error:
                raise read.Unreadable(f"the model was not drawn: {error}") from None
            if ran.returncode == 0 and picture.is_file():
                return picture.read_text(encoding="utf-8")
            problem = problem or ran.stderr.strip() or ran.stdout.strip()
    raise read.Unreadable(f"the model was not drawn by {program}: {problem}")
