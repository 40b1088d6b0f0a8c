#!/usr/bin/env python3
"""Treatment of a result folder that is not empty.

    folders.py PROGRAM DECK FOLDER
"""
import pathlib
import shutil
import signal
import subprocess
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from part import run_checks  # noqa: E402
from program import Program, summary  # noqa: E402

MINE = ("notes.txt", "old/results.h5", "figures/table.txt", "checkpoint_of_mine.h5",
        "fields/camera.json")  # names that trackbed does not write at these places


def contents(folder):
    """Path, size and time of change of each file except the lock, which is empty and remains."""
    return {str(path.relative_to(folder)): (path.stat().st_size, path.stat().st_mtime_ns)
            for path in folder.rglob("*") if path.is_file() and path.name != ".lock"}


def put_mine(folder):
    for name in MINE:
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).write_text("kept", encoding="utf-8")


def refused(program, ranks, arguments, words):
    """One message, exit code 2, before anything is computed."""
    ran = program.done(ranks, *arguments, code=2)
    lines = [line for line in ran.stderr.splitlines() if line.startswith(str(words[0]))]
    if len(lines) != 1 or not all(str(word) in lines[0] for word in words):
        raise SystemExit(f"{arguments} must report in one message {words}:\n{ran.stderr}")
    if arguments[0] != "info" and "stage " in ran.stdout:  # info states how far the run is
        raise SystemExit(f"{arguments} started to compute:\n{ran.stdout}")


def check_old_results(program, deck, folder):
    made = folder / "made"
    program.done(1, "run", deck, "output.fields=true", "-o", made)
    own = set(contents(made))
    put_mine(made)
    before = contents(made)
    for ranks in (1, 2):
        refused(program, ranks, ["run", deck, "-o", made], [made, "--force", "run (", "); choose"])
    stopped = folder / "stopped_early"
    program.done(1, "run", deck, "output.stop_after=5", "-o", stopped, code=3)
    refused(program, 1, ["run", deck, "-o", stopped],
            [stopped, "--force", f"trackbed resume {stopped}", "-o DIR"])
    # Each alone is a reason, but not the drawing, which a run leaves that fails at its start.
    for name in sorted(own - {"model.svg"}):
        place = folder / "one"
        (place / name).parent.mkdir(parents=True)
        (place / name).touch()
        refused(program, 1, ["run", deck, "-o", place], [place, name, "--force"])
        shutil.rmtree(place)
    link = folder / "link"
    link.symlink_to(made / "stage_sleepers.h5")
    for start in (made / "stage_sleepers.h5", link):
        refused(program, 2, ["run", deck, f"start={start}", "--force", "-o", made],
                [made, start.name, "another folder"])
    refused(program, 2, ["run", deck, f"start={made}", "-o", folder / "new"],
            ["command line", "stage_passage.h5", "no stage is left"])
    refused(program, 1, ["run", deck, f"start={made / 'stage_fill.h5'}", "stage.fill.name=other",
                         "--force", "-o", made], ["command line", "stage_fill.h5", "does not have"])
    if contents(made) != before:
        raise SystemExit("a refused run changed the folder")
    stopped = ["output.stop_after=1", "-o", made]
    program.done(2, "run", deck, "--force", *stopped, code=3)
    after = contents(made)
    kept = {name for name in after if after[name] == before.get(name)}
    if kept != set(MINE):
        raise SystemExit(f"kept by --force: {sorted(kept)}, not {sorted(MINE)}")
    if set(after) - kept != {"results.h5", "summary.json", "latest", "progress.jsonl", "model.svg",
                             "checkpoint_0000000001.h5"}:
        raise SystemExit(f"not only the files of the new run: {sorted(after)}")
    program.done(1, "resume", made)
    program.done(1, "run", deck, "--force", *stopped[:1], "-o", folder / "new", code=3)


def check_start_beside(program, deck, folder):
    """A run may start repeatedly from a checkpoint of the folder above its own."""
    made = folder / "made"
    for _ in range(2):
        program.done(1, "run", deck, f"start={made / 'stage_load.h5'}", "--force", "-o",
                     made / "variant")
        if not summary(made / "variant")["finished"]:
            raise SystemExit("the variant did not finish")


def check_resume_elsewhere(program, deck, folder):
    """Results of another run are not replaced by `resume -o`, as by `run`."""
    stopped, other, link = folder / "stopped", folder / "other", folder / "same"
    for place in (stopped, other):
        program.done(1, "run", deck, "output.stop_after=1", "-o", place, code=3)
    before = contents(other)
    for ranks in (1, 2):
        refused(program, ranks, ["resume", stopped, "-o", other], [other, "--force", "-o DIR"])
    if contents(other) != before:
        raise SystemExit("a refused resume changed the folder")
    program.done(1, "resume", stopped, "--force", "-o", other)
    if not summary(other)["finished"] or (other / "checkpoint_0000000001.h5").exists():
        raise SystemExit("--force must not change the resumed run in its folder")
    link.symlink_to(stopped)
    program.done(1, "resume", stopped, "-o", link)  # its own folder by another name
    if not summary(stopped)["finished"]:
        raise SystemExit("the run resumed into its own folder did not finish")


def check_two_at_once(program, deck, folder):
    """Only one run at a time can write a folder; the attempt does not affect the first."""
    place = folder / "two"
    # Long enough not to end in the meantime; stopped after all checks.
    long = ["stage.fill.duration=10000", "output.checkpoint_interval=0.1"]
    with subprocess.Popen([program.path, "run", deck, *long, "-o", str(place)],
                          stdout=subprocess.DEVNULL) as first:
        while not (place / "latest").exists() and first.poll() is None:
            time.sleep(0.01)
        for command in (["resume", place], ["run", deck, "--force", "-o", place]):
            refused(program, 2, command, [place, "another run is writing", "-o DIR"])
        first.send_signal(signal.SIGUSR1)
        if first.wait() != 3:
            raise SystemExit("the run was disturbed by another")
    program.done(1, "info", place / "results.h5")


def check_damaged(program, deck, folder):
    """`start` and `info` require the latest checkpoint; `resume` uses the newest valid one."""
    made = folder / "made"
    files = sorted((path for path in made.glob("*.h5") if path.name != "results.h5"),
                   key=lambda path: path.stat().st_mtime_ns)
    latest, before = files[-1], files[-2]
    if (made / "latest").read_text(encoding="utf-8").splitlines()[0] != latest.name:
        raise SystemExit(f"{latest} is not the latest")
    if str(latest) not in program.done(2, "info", made).stdout:
        raise SystemExit(f"info {made} must name the file")
    with open(latest, "r+b") as file:
        file.truncate(latest.stat().st_size // 2)
    for ranks in (1, 2):
        for command in (["info", made], ["check", deck, f"start={made}"],
                        ["run", deck, f"start={made}", "-o", folder / "never"]):
            refused(program, ranks, command, [latest, "cut short"])
    if (folder / "never").exists():
        raise SystemExit("a refused start must not leave files")
    ran = program.done(2, "resume", made)
    if f"warning: {latest}: " not in ran.stdout or f"continuing from {before}\n" not in ran.stdout:
        raise SystemExit(f"resume must say that it goes on from {before}:\n{ran.stdout}")
    if not summary(made)["finished"]:
        raise SystemExit("the resumed run did not finish")


def check_histories(program, deck, folder):
    """Damaged histories are refused; removed ones are reported as lost."""
    place, copy = folder / "histories", folder / "copy"
    program.done(1, "run", deck, "output.stop_after=500", "-o", place, code=3)
    results = place / "results.h5"
    whole = results.read_bytes()
    shutil.copytree(place, copy)
    program.done(1, "resume", copy, "output.stop_after=600", code=3)
    for bad in (whole[:len(whole) // 2], b"no results\n", b"",
                (place / "checkpoint_0000000500.h5").read_bytes()):
        results.write_bytes(bad)
        before = contents(place)
        for ranks in (1, 2):
            refused(program, ranks, ["resume", place],
                    [results, "damaged", "histories", "move it away"])
        refused(program, 1, ["resume", place, "--force", "-o", copy], [results, "damaged"])
        refused(program, 1, ["info", results], [results, "damaged"])
        if contents(place) != before:
            raise SystemExit("a refused resume changed the folder")
    results.unlink()
    for ranks in (2, 1):  # twice from the same checkpoint, as after a kill
        ran = program.done(ranks, "resume", place / "checkpoint_0000000500.h5", "--force",
                           "output.stop_after=600", code=3)
        if f"warning: {results}: does not exist" not in ran.stdout or "are lost" not in ran.stdout:
            raise SystemExit(f"lost histories must give a warning:\n{ran.stdout}")
        if ranks == 2:
            refused(program, 1, ["resume", place / "checkpoint_0000000500.h5", "--force"],
                    [results, "history rows before the checkpoint", "move it away"])
            results.unlink()
    if summary(copy)["dem"]["state_hash"] != summary(place)["dem"]["state_hash"]:
        raise SystemExit("the histories have changed the motion")
    results.write_bytes(whole)
    ran = program.done(1, "resume", place / "checkpoint_0000000500.h5", "--force",
                       "output.stop_after=600", code=3)
    if "warning: " + str(results) in ran.stdout:
        raise SystemExit("complete histories must not give a warning")


def check_parts(program, deck, folder):
    """Incomplete files of a killed run are removed once the resumed run is accepted."""
    place = folder / "parts"
    program.done(1, "run", deck, "output.stop_after=500", "-o", place, code=3)
    own = ("checkpoint_0000000600.h5.part", "stage_fill.h5.part", "results.h5.part", "latest.part")
    mine = ("notes.part", "checkpoint_of_mine.h5.part", "data.h5.part")
    for name in own + mine:
        (place / name).write_text("half", encoding="utf-8")
    refused(program, 1, ["resume", place, "output.stop_after=1"],
            ["command line: ", "the run has already computed"])
    if not all((place / name).exists() for name in own):
        raise SystemExit("a refused resume has removed files")
    program.done(2, "resume", place, "output.stop_after=550", code=3)
    left = {path.name for path in place.glob("*.part")}
    if left != set(mine):
        raise SystemExit(f"after a resume {left} remain, not {mine}")


def main():
    program, deck, folder = Program(sys.argv[1]), sys.argv[2], pathlib.Path(sys.argv[3])
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    # The first makes the results that others use.
    run_checks((check_old_results, check_start_beside, check_resume_elsewhere, check_damaged,
                check_two_at_once, check_histories, check_parts), program, deck, folder)


if __name__ == "__main__":
    main()
