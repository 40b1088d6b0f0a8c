#!/usr/bin/env python3
"""The decks of the quickstart in a short form, with and without wedge, and their figures and film.

    quickstart.py PROGRAM SOURCE_FOLDER FOLDER
"""
import pathlib
import shutil
import subprocess
import sys

import h5py
import numpy as np
from PIL import Image

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from program import Program, summary  # noqa: E402
from results import checkpoint, histories  # noqa: E402

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "postproc"))
from trackbed_post import ground_blocks, read, zones  # noqa: E402

# A loose bed, hardly bedded in; the train passes at 900 m/s.
CELL = ["stage.fill.duration=0.15", "stage.compact.duration=0.1", "platen.speed=2",
        "stage.release.duration=0.005", "stage.rest.duration=0.005"]
DECK = ["stage.lay.duration=0.002", "stage.sleepers.duration=0.02", "stage.bed_in.duration=0.005",
        "stage.bed_in.cycles=1", "stage.rest.duration=0.005", "train.speed=900",
        "output.fields_interval=0.01"]
NO_WEDGE = ["ground.block.wedge.present=false", "ground.block.wedge_surface.present=false"]
STAGES = ["lay", "sleepers", "bed_in", "rest", "first_train", "train"]


def draw(source, *words):
    ran = subprocess.run([sys.executable, source / "postproc", *words], capture_output=True,
                         text=True, check=False)
    if ran.returncode or ran.stderr:
        raise SystemExit(f"{words}: {ran.returncode} {ran.stdout}{ran.stderr}")


def figures(source, folder, *runs, film=False):
    """What the commands `figures` and `film` write about these runs."""
    made = folder / "_".join(("figures", *runs))
    results = [folder / run for run in runs]
    draw(source, "figures", *results, "--kind", "transition", "-o", made)
    if film:
        draw(source, "film", *results, "-o", made / "film.gif")
    for name in ("model.png", "transition.png", "transition.txt"):
        if not (made / name).stat().st_size:
            raise SystemExit(f"{name} is missing or empty")
    if film:
        with Image.open(made / "film.gif") as frames:
            if frames.n_frames < 3:
                raise SystemExit(f"the film has {frames.n_frames} frames")
            size = frames.size
        draw(source, "film", results[0], "--fields", "--parts", "contacts", "--frames", "3", "-o",
             made / "fields.gif")
        with Image.open(made / "fields.gif") as frames:
            if frames.n_frames != 3 or frames.size == size:
                raise SystemExit("--fields does not decide between the two films")
    return (made / "transition.txt").read_text(encoding="utf-8")


def check_ends(made):
    """The loose bed does not match the springs beside it: a warning at each end states the lowest
    displacements of the rail in the last stage."""
    warnings = [text for text in summary(made)["warnings"] if "does not match the bed" in text]
    state = checkpoint(made)
    lowest, before = (1e3 * state[f"run/rail_ends/{name}"].reshape(4, 3)
                      for name in ("lowest", "before"))
    found = histories(made)
    rail = 1e3 * found["rail/displacement"][:, [0, 1, 2, -3, -2, -1]]
    rows = np.nanmin(rail, axis=0)
    bed = lowest[[0, 2]].ravel()  # of all windows, and so at most that of the rows
    # The first axle is 3 m before the third sleeper on springs, at x = -1.2 m of the bed.
    coming = np.flatnonzero(found["wheel/x"].max(axis=1) < -1.2 - 3)[-1]
    if not np.allclose(before[[0, 2]].ravel(), rail[coming], atol=0.5):
        raise SystemExit(f"the rail before the train: {before}, rows {rail[coming]} mm")
    if not (bed <= rows + 1e-9).all() or not np.allclose(bed, rows, rtol=0.02):
        raise SystemExit(f"lowest displacements of the rail {bed}, of the rows {rows} mm")
    for end, where in enumerate(("start", "end")):
        stones, springs = (before - lowest)[2 * end:2 * end + 2].mean(axis=1)
        # Pads of 120 MN/m and ballast of 60 times the factor of the zone.
        pad, ballast = 120e6, 60e6 * (1.9, 0.42)[end]
        whole = (springs / stones)**(4 / 3) / (1 / pad + 1 / ballast)
        bed = 1 / (1 / whole - 1 / pad) / 60e6
        text, = (each for each in warnings if f"at the {where} of the bed" in each)
        stated = [f"{stones:.2g} mm above the", f"{springs:.2g} mm above the",
                f"`bed` of about {bed:.2g} instead of"]
        if not all(words in text for words in stated):
            raise SystemExit(f"{stones} mm on stones and {springs} mm on springs: {text}")


def between_rows(found, name, time):
    """Of a history, linear in time."""
    rows = found["time"].ravel()
    after = min(max(int(np.searchsorted(rows, time)), 1), len(rows) - 1)
    part = (time - rows[after - 1]) / (rows[after] - rows[after - 1])
    return (1 - part) * found[name][after - 1] + part * found[name][after]


def check_rail(made):
    """Field files have the rail of the whole track, with the displacements of the histories above
    the sleepers of the bed; without these it has the same height at all times."""
    found = histories(made)
    levels = []
    for path in sorted((made / "fields").glob("train_*_train.hdf")):
        with h5py.File(path) as file:
            group = file["VTKHDF"]
            ends = 2 * int((group["CellData/wheel"][:] < 0).sum())  # two points of each line
            x, _, z = group["Points"][:ends].astype(float).T
            moved = group["PointData/displacement"][:ends, 2].astype(float)
            time = group["FieldData/TimeValue"][0]
        at = [np.argmin(np.abs(x - 0.6 * (k + 1))) for k in range(31)]
        off = np.abs(moved[at] - between_rows(found, "rail/displacement", time)).max()
        # Rows are 1 ms apart, between which the displacement is not quite linear in time, and the
        # last file is behind the last row.
        if not np.allclose((x.min(), x.max()), (-9.0, 31.8), atol=1e-4) or (
                off > 0.02 * np.abs(moved).max()):
            raise SystemExit(f"{path}: rail from {x.min()} to {x.max()} m, off by {off} m")
        levels.append(z - moved)
    if len(levels) < 3 or np.ptp(levels, axis=0).max() > 1e-6:
        raise SystemExit(f"the unloaded rail moves: {levels}")
    # Placed with their top at 0.52 m; drawn 0.172 m high on the highest seat.
    wanted = 0.52 + checkpoint(made)["run/rail/levels"].max() + 0.172
    if not np.allclose(levels, wanted, atol=1e-6):
        raise SystemExit(f"the unloaded rail is drawn at {levels[0]}, not at {wanted} m")


def check_parts(stated, run):
    """`check` counts the sleepers that comparisons judge as these do, if only blocks change the
    track."""
    zone = zones.zone_of(run, ground_blocks.wedge_length(run))
    words = (f"plain track from x = {run.sleepers_x[zone.plain].min():g} m or later",
             f"judge {zone.structure.sum()} of the sleepers on the structure and at most "
             f"{zone.plain.sum()} on plain track")
    if not all(each in stated for each in words):
        raise SystemExit(f"check must state {words}: {stated}")


def check_surfaces(made):
    """Contacts name the surfaces as their own files do; the ground, 0, is no surface there."""
    files = sorted((made / "fields").glob("train_*_contacts.hdf"))
    path = files[len(files) // 2]  # the train is on the loose bed
    with h5py.File(path) as file:
        time = file["VTKHDF/FieldData/TimeValue"][0]
        number = -1 - file["VTKHDF/PointData/stone"][:].ravel()
        ends = file["VTKHDF/Points"][:]
    with h5py.File(str(path).replace("contacts", "surfaces")) as file:
        group = file["VTKHDF"]
        corners = group["Points"][:][group["Connectivity"][:].reshape(-1, 3)]
        surface, part = (group[f"CellData/{name}"][:].ravel() for name in ("surface", "part"))
        moved = group["CellData/sleeper_displacement"][:]
    touched = set(number[number > 0])
    if 0 not in number or len(touched) < 2 or not touched <= set(surface) or 0 in surface:
        raise SystemExit(f"contacts touch {touched}, there are {set(surface)}")
    for each in touched:
        box = corners[surface == each].reshape(-1, 3)
        low, high = box.min(axis=0) - 1e-3, box.max(axis=0) + 1e-3
        at = ends[number == each]
        if not ((at > low) & (at < high)).all():
            raise SystemExit(f"contacts of surface {each} at {at}, which is in {low} to {high}")
    found = histories(made)
    row = found["sleeper/displacement"][np.argmin(np.abs(found["time"].ravel() - time))]
    shown = [moved[surface == each][0] for each in np.unique(surface[part == 2])]
    # A row may be up to half an interval of rows, 0.5 ms, before or after the file.
    if len(shown) != 31 or not np.allclose(np.array(shown)[:, 2], row, atol=5e-4):
        raise SystemExit(f"sleepers displaced by {shown}, by {row} in the histories")
    if moved[part != 2].any():
        raise SystemExit("only sleepers have a displacement")


def main():
    program, source, folder = Program(sys.argv[1]), *map(pathlib.Path, sys.argv[2:4])
    shutil.rmtree(folder, ignore_errors=True)
    inputs = source / "inputs"
    program.done(1, "run", inputs / "quickstart_cell.toml", *CELL, "-o", folder / "cell")
    deck = [inputs / "quickstart.toml", f"bed.cell={folder / 'cell'}", *DECK]
    program.done(1, "run", *deck, "-o", folder / "wedge")
    stages = [stage["name"] for stage in summary(folder / "wedge")["stages"]]
    if stages != STAGES:
        raise SystemExit(f"the deck has the stages {stages}")
    check_ends(folder / "wedge")
    check_rail(folder / "wedge")
    check_parts(program.done(1, "check", *deck).stdout, read.results(folder / "wedge"))
    check_surfaces(folder / "wedge")
    program.done(1, "run", *deck, *NO_WEDGE, f"start={folder / 'wedge/stage_bed_in.h5'}", "-o",
                 folder / "no_wedge")
    both = " ".join(figures(source, folder, "wedge", "no_wedge", film=True).split())
    # Such a bed settles under the trains: the levels may allow no verdict, but the decks do.
    if "With the wedge the " not in both and " differ by " not in both:
        raise SystemExit(f"no verdict on the wedge: {both}")
    for runs, why in ((("wedge",), "give a second run"),
                      (("no_wedge", "wedge"), "must have all blocks of the second")):
        text = figures(source, folder, *runs)
        if "No verdict: " not in text or why not in text:
            raise SystemExit(f"{runs}: no reason why there is no verdict: {text}")


if __name__ == "__main__":
    main()
