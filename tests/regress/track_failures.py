#!/usr/bin/env python3
"""A track alone that cannot continue: messages, remaining files, restart; pads that lift off, for
whose contacts plain Newton iteration does not converge.

    track_failures.py PROGRAM DECKS FOLDER
"""
import pathlib
import re
import resource
import shutil
import signal
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from program import Program, summary  # noqa: E402
from results import datasets  # noqa: E402


def want(text, *words):
    for word in words:
        if word not in text:
            raise SystemExit(f"it must report {word}: {text}")


def check_full_disk(path, deck, folder):
    """A limited file size simulates a full disk; checkpoints grow with their rows."""
    place, limit = folder / "full", 700_000  # bytes: some checkpoints, not the last
    with subprocess.Popen(
            [path, "run", deck, "output.checkpoint_interval=0.05", "output.history_interval=2e-4",
             "-o", place], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
            preexec_fn=lambda: signal.signal(signal.SIGXFSZ, signal.SIG_IGN)) as run:
        run.stdout.readline()  # only now, as MPI itself starts with larger files
        resource.prlimit(run.pid, resource.RLIMIT_FSIZE, (limit, limit))
        out, err = run.communicate(timeout=300)
    ran = subprocess.CompletedProcess(run.args, run.returncode, out, err)
    if ran.returncode != 4:
        raise SystemExit(f"a full disk must end with 4: {ran}")
    good = place / (place / "latest").read_text(encoding="utf-8").splitlines()[0]
    want(ran.stderr, "(File too large)", f"last valid checkpoint: {good}",
         f"continue with: trackbed resume {good}")
    if list(place.glob("*.part")):
        raise SystemExit(f"incomplete files remain: {list(place.iterdir())}")
    Program(path).done(1, "resume", good, f"output.stop_after={int(good.stem[-10:]) + 5}", code=3)


def check_error(program, deck, folder):
    """Contact iterations that do not converge: the rows up to now are written, and the missing
    checkpoint is reported."""
    ran = program.done(1, "run", deck, "passage.tolerance=1e-20", "output.history_interval=2e-4",
                       "-o", folder / "open", code=4)
    found = re.search(r"to passage.tolerance = 1e-20 m.*\(at ([0-9.]+) s, stage", ran.stderr)
    want(ran.stderr, "no checkpoint was written")
    last = datasets(folder / "open")["history/time"].ravel()[-1]
    if not found or not 0 < last < float(found[1]) + 1e-9 < last + 3e-4:
        raise SystemExit(f"rows before the error must be kept: up to {last} s: {ran.stderr}")


def check_changed_file(program, deck, folder):
    """The profile cannot be changed within a passage."""
    profile, place = folder / "profile.csv", folder / "half"
    words = ["irregularity.kind=file", f"irregularity.file={profile.resolve()}"]
    profile.write_text("x_m,z_m\n0,0\n30,-3e-3\n60,0\n", encoding="utf-8")
    program.done(1, "run", deck, *words, "output.stop_after=50", "-o", place, code=3)
    profile.write_text("x_m,z_m\n0,0\n30,-30e-3\n60,0\n", encoding="utf-8")
    want(program.done(1, "resume", place, code=2).stderr,
         "the content of the file has changed since")
    profile.write_text("x_m,z_m\n0,0\n30,-3e-3\n60,0\n", encoding="utf-8")
    program.done(1, "resume", place, "output.stop_after=60", code=3)


def check_no_loads(program, decks, folder):
    """Seat loads that begin behind the track, wheels that never reach it."""
    want(program.done(1, "run", decks / "seats.toml", "load.start=1000", "-o", folder / "none",
                      code=2).stderr, "seat loads would last -")
    ran = program.done(1, "run", decks / "plain.toml", "train.start=-30", "passage.duration=0.1",
                       "-o", folder / "before")
    if "wheel forces: " in ran.stdout or "wheel_force_max_n" in summary(folder / "before")["track"]:
        raise SystemExit(f"no wheel was on the track: {ran.stdout}")


def check_uplift(program, decks, folder):
    """Forces of three slopes: full Newton steps oscillated without converging, in crossing after 13
    ms, in hammer after 10 ms, in netirail_plain after 33 ms."""
    for name, duration in (("crossing", 0.02), ("hammer", 0.02), ("netirail_plain", 0.05)):
        program.done(1, "run", decks / f"{name}.toml", "pad.uplift=true", "pad.preload=0",
                     f"passage.duration={duration}", "-o", folder / name)
        if not summary(folder / name)["finished"]:
            raise SystemExit(f"{name}: {summary(folder / name)}")


def main():
    path, decks, folder = sys.argv[1], *map(pathlib.Path, sys.argv[2:4])
    deck = decks / "plain.toml"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    check_full_disk(path, deck, folder)
    check_error(Program(path), deck, folder)
    check_changed_file(Program(path), deck, folder)
    check_no_loads(Program(path), decks, folder)
    check_uplift(Program(path), decks, folder)


if __name__ == "__main__":
    main()
