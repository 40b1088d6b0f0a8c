#!/usr/bin/env python3
"""Files of a deck that were moved after a checkpoint was written: with unchanged contents the run
can continue, otherwise not.

    moved_files.py PROGRAM DECK FOLDER
"""
import pathlib
import shutil
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from program import Program, expect, summary  # noqa: E402
from results import same_bits  # noqa: E402

INPUTS = pathlib.Path(__file__).resolve().parents[2] / "inputs"
# Embankment deck: few stones for a short time. Track deck: the first metres.
SHORT = ["bed.x=[0.7, 1.1]", "bed.y=[-0.2, 0.2]", "bed.height=0.06", "stage.fill.duration=0.02",
         "stage.compact.duration=0.01", "output.fields=false"]
FAR = ["passage.duration=0.05"]


def stop_of(whole):
    """In the middle of the passage, or some windows before the end of the last stage."""
    if "stages" not in whole:
        return "output.stop_after=20"
    windows = sum(round(stage["duration_s"] / stage["window_s"]) for stage in whole["stages"])
    return f"output.stop_after={windows - 10}"


def check_moved(program, deck, words, name, old, folder):
    """A stopped run is resumed where the file `old` is in another place; bitwise identical to an
    uninterrupted run. Then the file has other contents, in the new and the old place."""
    whole, stopped, new = folder / "whole", folder / "stopped", folder / "moved" / old.name
    program.done(1, "run", deck, *words, f"{name}={old}", "-o", whole)
    stop = stop_of(summary(whole))
    program.done(1, "run", deck, *words, f"{name}={old}", stop, "-o", stopped, code=3)
    shutil.copytree(stopped, folder / "again")
    new.parent.mkdir()
    shutil.move(old, new)
    ran = program(1, "resume", stopped)
    expect(ran.returncode == 2 and str(old) in ran.stderr, "the file is gone", ran)
    ran = program.done(1, "resume", stopped, f"{name}={new}")
    expect("where the run was resumed" not in ran.stdout and
           not any("resumed" in text for text in summary(stopped)["warnings"]),
           f"{name}: the same file is no change", ran)
    same_bits(whole, stopped, f"{name} moved", lambda of: of.get("dem", {}).get("state_hash"),
              "history/")
    new.write_text(new.read_text(encoding="utf-8") + "\n", encoding="utf-8")
    ran = program(1, "resume", folder / "again", f"{name}={new}")
    expect(ran.returncode == 2 and f"{old}" in ran.stderr, "another file in another place", ran)
    shutil.copy(new, old)
    ran = program(1, "resume", folder / "again")
    expect(ran.returncode == 2 and "the content of the file has changed since" in ran.stderr,
           f"{name}: another file in the old place", ran)


def check_unread(program, folder):
    """A file that is named but not read may change; changes of resumes are kept in the warnings."""
    unread, place = folder / "unread.csv", folder / "unread"
    unread.write_text("x_m,z_m\n0,0\n30,0\n", encoding="utf-8")
    program.done(1, "run", INPUTS / "track/plain.toml", *FAR, "irregularity.kind=spectrum",
                 f"irregularity.file={unread}", f"title={unread}", "output.stop_after=20",
                 "-o", place, code=3)
    unread.write_text("x_m,z_m\n0,0\n60,0\n", encoding="utf-8")
    program.done(1, "resume", place, "passage.duration=0.06", "passage.tolerance=1e-11",
                 "output.stop_after=30", code=3)
    program.done(2, "resume", place, "output.stop_after=0")
    kept = [text for text in summary(place)["warnings"] if "resumed" in text]
    if len(kept) != 1 or "passage.tolerance = " not in kept[0]:
        raise SystemExit(f"changes of a resume must be kept, and nothing else: {kept}")


def main():
    program, deck, folder = Program(sys.argv[1]), sys.argv[2], pathlib.Path(sys.argv[3]).resolve()
    shutil.rmtree(folder, ignore_errors=True)
    for case in ("mesh", "wave", "track"):
        (folder / case).mkdir(parents=True)
    soil, wave, rail = (folder / "mesh/soil.msh", folder / "wave/wave.csv",
                        folder / "track/rail.csv")
    shutil.copy(INPUTS / "ground/embankment.msh", soil)
    wave.write_text("time_s,vx_m_s,vz_m_s\n0,0,0\n0.01,0,0.01\n0.02,0,0\n", encoding="utf-8")
    rail.write_text("x_m,z_m\n0,0\n30,0.001\n90,0\n", encoding="utf-8")
    check_moved(program, INPUTS / "ground/embankment.toml", SHORT, "ground.mesh", soil,
                folder / "mesh")
    check_moved(program, deck, ["ground.sides=free_field", "ground.base_stiffness=0"],
                "ground.base_motion", wave, folder / "wave")
    check_moved(program, INPUTS / "track/plain.toml", [*FAR, "irregularity.kind=file"],
                "irregularity.file", rail, folder / "track")


if __name__ == "__main__":
    main()
