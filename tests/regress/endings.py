#!/usr/bin/env python3
"""How runs end, and what can continue from them: exit codes, lost output, a full disk, signals,
checkpoints of other models, of finished runs, of other folders.

    endings.py PROGRAM DECK FOLDER
"""
import os
import pathlib
import re
import resource
import shutil
import signal
import subprocess
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from part import run_checks  # noqa: E402
from program import Program, expect, summary  # noqa: E402
import results  # noqa: E402, F401  # finds trackbed_post
from trackbed_post import read  # noqa: E402


def check_other_models(program, deck, folder):
    """A checkpoint is the state of one model: a deck of another model cannot start from it."""
    made = folder / "made"
    program.done(1, "run", deck, "-o", made)
    still, moved = f"start={made / 'stage_sleepers.h5'}", f"start={made / 'stage_load.h5'}"
    place = ["-o", folder / "other"]
    borders = ["ground.base=fixed", "ground.base_stiffness=0", "ground.sides=viscous",
               "ground.plane=strain"]
    refused = [(change, moved) for change in borders]
    refused += [("ground.elements_x=30", still), ("sleepers.count=1", still),
                ("sleepers.y=0.01", still), ("bed.x=[0, 1.1]", still),
                ("ground.layer.soil.thickness=0.5", still), ("ground.ratio_x=1.1", still),
                ("ground.block.structure.present=false", moved)]
    for change, start in refused:
        for command in (["run", deck, start, change, *place], ["check", deck, start, change]):
            ran = program(1, *command)
            expect(ran.returncode == 2, f"{command} must be refused", ran)
            expect(change.split("=")[0].split(".")[-1] in ran.stderr and
                   "was made with" in ran.stderr, f"{command} must report the reason", ran)
    # Stones refer to a material by number: a new first material must not replace theirs.
    lead = folder / "lead.toml"
    lead.write_text(pathlib.Path(deck).read_text().replace(
        "[[material]]", '[[material]]\nname = "lead"\ndensity = 11340\n\n[[material]]', 1))
    ran = program(1, "check", lead, still)
    expect(ran.returncode == 2 and "material" in ran.stderr and "was made with" in ran.stderr,
           "materials in another order must be refused", ran)
    ran = program(1, "resume", made / "stage_load.h5", "ground.elements_x=30", *place)
    expect(ran.returncode == 2, "resume must also refuse it", ran)
    ran = program(1, "check", deck, moved, "stage.load.duration=0.011")
    expect(ran.returncode == 0 and "has no effect: this stage is over" in ran.stdout,
           "a start must warn of a changed stage that is over", ran)
    check_spent(program, deck, made, place)
    expect(not (folder / "other").exists(), "a refused start must not leave files", ran)
    program.done(1, "run", deck, still, "ground.block.structure.present=false", *place)
    program.done(1, "check", deck, still, *borders)
    check_integrators(program, deck, folder, still, moved)
    check_old_runs(program, made, still)


def check_old_runs(program, made, other):
    """A finished run is not changed, and results later than a checkpoint are not replaced unless
    requested; what a resumed run changes is recorded with its results."""
    before = (made / "summary.json").read_bytes()
    ran = program(1, "resume", made)
    expect(ran.returncode == 0 and "the run is already finished" in ran.stdout,
           "a finished run", ran)
    expect((made / "summary.json").read_bytes() == before, "its summary must stay", ran)
    ran = program(1, "resume", made / "stage_load.h5", "dem.gravity=9.8")
    expect(ran.returncode == 2 and "is not the newest checkpoint" in ran.stderr and
           "--force" in ran.stderr, "later results must not be replaced", ran)
    ran = program(1, "resume", made / "stage_load.h5", other, "-o", made.parent / "elsewhere")
    expect(ran.returncode == 2 and "start has no effect" in ran.stderr,
           "a start with resume must be refused", ran)
    program.done(1, "resume", made / "stage_load.h5", "dem.gravity=9.8",
                 "output.surface_cell=0.08", "output.wall_time=1e5", "--force")
    warned = summary(made)["warnings"]
    expect([found[1] for text in warned
            if (found := re.search(r"(output\.\S+) = .* s on, where the run was resumed", text))]
           == ["output.surface_cell"],
           f"what is written, but not when to stop, not {warned}", ran)
    gravity = r"dem\.gravity = 9\.8 \(previously 9\.81\) from \S+ s on, where the run was resumed"
    expect(any(re.search(gravity, text.replace("9.8000000000000007", "9.8").replace(
        "9.8100000000000005", "9.81")) for text in warned),
        f"a changed value must be kept with the results, not {warned}", ran)


def check_spent(program, deck, made, place):
    """Parameters of finished stages cannot be changed; others can."""
    for change, why in (("bed.seed=5", "the stones have already been made"),
                        ("platen.pressure=30e3", "the platen loads the bed in no remaining stage"),
                        ("stage.fill.duration=1", "this stage is over"),
                        ("settle_average=1", "the ground already moves"),
                        ("output.stop_after=1", "the run has already computed")):
        ran = program(1, "resume", made / "stage_load.h5", change, *place)
        expect(ran.returncode == 2 and why in ran.stderr, f"resume with {change} must report {why}",
               ran)
    start = f"start={made / 'stage_load.h5'}"
    ran = program(1, "check", deck, start, "bed.seed=5")
    expect(ran.returncode == 0 and "warning: " in ran.stdout and
           "the stones have already been made" in ran.stdout,
           "another bed than that of the checkpoint must give a warning", ran)


def check_integrators(program, deck, folder, still, moved):
    """Newmark steps can follow explicit steps, but not the reverse."""
    newmark, explicit = "ground.integrator=newmark", "ground.integrator=explicit"
    program.done(1, "check", deck, still, newmark)
    place = folder / "newmark"
    program.done(1, "run", deck, moved, newmark, "output.stop_after=3", "-o", place, code=3)
    ran = program(1, "resume", place, explicit)
    expect(ran.returncode == 2 and "ground.integrator" in ran.stderr and
           'was made with "newmark"' in ran.stderr, "explicit steps after Newmark's", ran)
    program.done(1, "resume", place)


def check_foreign_folder(program, _, folder):
    """Foreign files in a folder are not checkpoints; a checkpoint under another name is."""
    place = folder / "foreign"
    place.mkdir()
    shutil.copy(folder / "made/results.h5", place / "big.h5")
    (place / "text.h5").write_text("no checkpoint\n", encoding="utf-8")
    ran = program(1, "resume", place)
    expect(ran.returncode == 2 and len(ran.stderr.splitlines()) == 1 and
           ran.stderr.startswith(f"{place}: contains no checkpoint"), "foreign files", ran)
    shutil.copy(folder / "made/stage_load.h5", place / "kept.h5")
    ran = program(1, "resume", place, "bed.seed=5")
    expect(ran.returncode == 2 and "kept.h5" in ran.stderr and
           "the stones have already been made" in ran.stderr,
           "a checkpoint under another name must be found", ran)


def check_lost_output(program, deck, folder):
    """Output that cannot be written is an error, except for a run, whose results are files."""
    place = folder / "unheard"
    cases = [(["schema"], 4), (["describe"], 4), (["describe", "stage"], 4), (["--help"], 4),
             (["--version"], 4), (["check", deck], 4), (["shapes", "--stones", "2"], 4),
             (["info", folder / "made/stage_load.h5"], 4), (["info", "no_such_file.h5"], 2),
             (["run", deck, "output.stop_after=100", "-o", place], 3), (["resume", place], 0)]
    for arguments, code in cases:
        with open("/dev/full", "w", encoding="utf-8") as full:
            ran = subprocess.run([program.path, *map(str, arguments)], stdout=full,
                                 stderr=subprocess.PIPE, text=True, timeout=120, check=False)
        ran.stdout = ""
        expect(ran.returncode == code,
               f"{arguments} without standard output must end with {code}", ran)
        expect(("standard output cannot be written" in ran.stderr) == (code == 4),
               f"{arguments} must report that its output is lost", ran)
    expect(summary(place)["finished"], "a run without standard output must continue", ran)


def check_run_error(program, deck, folder):
    ran = program(1, "run", deck, "dem.largest_overlap=1e-9", "-o", folder / "overlap")
    expect(ran.returncode == 4, "a run-time error must end with 4", ran)
    expect("checkpoint" in ran.stderr, "it must name the last good checkpoint or report none", ran)
    # What can be seen of the failure: fields of the moment, and the histories up to it.
    for ranks in (1, 2):
        place = folder / f"overlap_{ranks}"
        ran = program(ranks, "run", deck, "dem.largest_overlap=1e-9", "-o", place)
        named = ran.stderr.partition("its state then is in ")[2].partition("_*.hdf")[0]
        expect(pathlib.Path(f"{named}_stones.hdf").is_file(), "it must write its state", ran)
        rows = read.datasets(place)["history/time"].values
        expect(len(rows) > 0, "it must write the histories up to the error", ran)


def check_full_disk(program, deck, folder):
    """A limited file size simulates a full disk: the system calls fail in the same places."""
    place = folder / "full"

    limit = 3_000_000  # bytes: more than a checkpoint, less than the histories of a few seconds
    with subprocess.Popen([program.path, "run", deck, "stage.fill.duration=10000", "-o", place],
                          stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                          preexec_fn=lambda: signal.signal(signal.SIGXFSZ, signal.SIG_IGN)) as run:
        for line in run.stdout:
            if line.startswith("stage fill:"):
                break
        # Only now, as MPI itself starts with larger files.
        resource.prlimit(run.pid, resource.RLIMIT_FSIZE, (limit, limit))
        out, err = run.communicate(timeout=120)
    ran = subprocess.CompletedProcess(run.args, run.returncode, out, err)
    expect(ran.returncode == 4, "a full disk must end with 4", ran)
    good = place / (place / "latest").read_text(encoding="utf-8").splitlines()[0]
    for words in (f"{place}/results.h5.part: ", "(File too large)",
                  f"last valid checkpoint: {good}",
                  f"continue with: trackbed resume {good}"):
        expect(words in ran.stderr, f"a full disk must say {words}", ran)
    expect(not list(place.glob("*.part")), "nothing half written may stay on a full disk", ran)
    windows = int(good.stem.rpartition("_")[2]) + 100
    program.done(1, "resume", good, f"output.stop_after={windows}", code=3)


def check_signals(program, deck, folder):
    for number in (signal.SIGTERM, signal.SIGUSR1):
        place = folder / f"signal_{number}"
        with subprocess.Popen([program.path, "run", deck, "-o", place], stdout=subprocess.PIPE,
                              stderr=subprocess.PIPE, text=True) as running:
            for line in running.stdout:
                if re.match(r"stage \w+:", line):
                    break
            time.sleep(0.3)
            running.send_signal(number)
            running.communicate(timeout=60)
            code = running.returncode
        if code != 3 or not list(place.glob("checkpoint_*.h5")) or not (place / "latest").exists():
            raise SystemExit(f"signal {number}: code {code}, {list(place.glob('*'))}")


def check_solver_options(program, deck, folder):
    """Invalid words after -- are reported as they were given."""
    cases = [(["ground_ksp_type=cg"], '"ground_ksp_type=cg" is not an option'),
             (["-ground_pc_type", "nosuch"], "(after `--`: -ground_pc_type nosuch)"),
             (["-ground_pc_type", "lu", "-ground_pc_factor_mat_solver_type", "superlu_nope"],
              "superlu_nope"),
             (["-ground_ksp_rtol", "-1"], "-ground_ksp_rtol = -1: must be at least 0 and below 1"),
             (["-ground_ksp_max_it", "-5"], "-ground_ksp_max_it = -5: must be at least 0"),
             (["-options_file", "nofile"], "-options_file nofile: this file cannot be read"),
             (["-log_view", ":/nonexistent/x"],
              "-log_view :/nonexistent/x: this file cannot be written"),
             (["-ground_ksp_type"], "(after `--`: -ground_ksp_type)")]
    start = f"start={folder / 'made/stage_sleepers.h5'}"
    run = ["run", deck, start, "-o", folder / "options", "--force"]
    for options, words in cases:
        for ranks, command in ((1, run), (2, run), (1, ["check", deck, start])):
            ran = program(ranks, *command, "--", *options)
            expect(ran.returncode == 2 and words in ran.stderr and "PETSC ERROR" not in ran.stderr,
                   f"{command[0]} on {ranks} ranks: {options} must be refused", ran)
    for options, words in (("-ground_pc_type nosuch", "(in PETSC_OPTIONS: -ground_pc_type nosuch)"),
                           ("-options_file nofile", "PETSC_OPTIONS: -options_file nofile: this")):
        os.environ["PETSC_OPTIONS"] = options
        ran = program(1, *run)
        del os.environ["PETSC_OPTIONS"]
        expect(ran.returncode == 2 and words in ran.stderr, f"PETSC_OPTIONS={options}", ran)
    program.done(1, "check", deck, start, "--", "-log_view", f":{folder}/log.txt")
    check_refused_options_remove_nothing(program, deck, folder, start)
    check_tried_options(program, deck, folder, start)


def check_refused_options_remove_nothing(program, deck, folder, start):
    """Options refused by PETSc, and numerical errors, must not remove old results."""
    place = folder / "kept"
    shutil.copytree(folder / "made", place)
    before = {path: path.stat().st_mtime_ns for path in place.rglob("*")}
    singular = ["-ground_pc_type", "lu", "-ground_pc_factor_zeropivot", "1e30",
                "-ground_ksp_error_if_not_converged"]
    commands = (["run", deck, start], ["resume", folder / "made/stage_sleepers.h5"])
    for options, code in ((["-ground_ksp_type", "nosuch"], 2), (singular, 4)):
        for command in commands:
            ran = program(1, *command, "-o", place, "--force", "--", *options)
            expect(ran.returncode == code and "PETSC ERROR" not in ran.stderr,
                   f"{command[0]} with {options} must end with {code}", ran)
            expect({path: path.stat().st_mtime_ns for path in place.rglob("*")} == before,
                   f"{command[0]} with {options} must not change old results", ran)


def check_tried_options(program, deck, folder, start):
    """The trial uses ground and solvers of the run, but only the run writes files of options."""
    blocks = ["-ground_pc_type", "bjacobi", "-ground_pc_bjacobi_blocks"]
    implicit = ["ground.integrator=newmark", "ground.plane=strain",
                "ground.layer.soil.yield=mohr_coulomb"]
    run = ["run", deck, start, "-o", folder / "tried", "--force"]
    for command in (run, ["check", deck, start]):
        program.done(1, *command, "--", *blocks, "40")
        program.done(1, *command, "--", *blocks, "100000", code=2)
        for name in ("ksp_type", "direct_pc_factor_mat_solver_type"):
            option = f"-ground_tangent_{name}"
            ran = program(1, *command, *implicit, "--", option, "nosuch")
            expect(ran.returncode == 2 and f": {option} nosuch)" in ran.stderr,
                   f"{command[0]}: {option} must be refused", ran)
    view, matrix = folder / "view.txt", folder / "matrix.txt"
    options = ["-ground_ksp_view", f"ascii:{view}", "-mat_view", f":{matrix}"]
    ran = program.done(1, "check", deck, start, "--", *options)
    expect(not view.exists() and not matrix.exists(), "check must not write files", ran)
    ran = program.done(1, *run, "--", *options[:2], "-ground_ksp_tpye", "cg")
    expect("KSP Object" in view.read_text(), "the run writes them", ran)
    for option, unused in (("ground_ksp_tpye", True), ("ground_ksp_view", False)):
        expect((f"the PETSc option -{option} was set but never used" in ran.stdout) == unused,
               f"-{option}: what a trial has asked for the run may not", ran)
    check_unused_options(program, deck, start)
    program.done(1, "check", deck, start, "--", "-info", ":/nonexistent/ksp")
    program.done(1, "check", deck, start, "--", "-info", "/nonexistent/file:ksp", code=2)


# Options that a run uses late, some only in a solve, or that PETSc itself uses.
ASKED_LATER = [
    "-ground_ksp_converged_reason", "-ground_pc_type", "gamg", "-ground_pc_gamg_threshold", "0.01",
    "-ground_mg_levels_esteig_ksp_max_it", "8", "-log_view", "ascii:/dev/null",
    "-ground_mg_coarse_sub_pc_type", "lu", "-ground_mg_coarse_sub_pc_factor_mat_solver_type",
    "mumps", "-ground_mg_coarse_sub_mat_mumps_icntl_14", "50"]


def check_unused_options(program, deck, start):
    """`check` reports misspelt and unused options, and none that a run would use."""
    yields = ["ground.integrator=newmark", "ground.plane=strain",
              "ground.layer.soil.yield=mohr_coulomb"]
    tangent = ["-ground_tangent_ksp_type", "gmres",
               "-ground_tangent_direct_mat_mumps_icntl_14", "9"]
    never = [f"stage.{name}.ground_moves=false" for name in ("load", "passage")]
    for changes, options, named in (
            ([], ["-ground_pc_typ", "gamg", "-mat_viw"], ["ground_pc_typ", "mat_viw"]),
            (yields[:2], ASKED_LATER, []),
            (yields, tangent, []),
            ([], tangent[:2], ["ground_tangent_ksp_type"]),
            (never, ["-ground_ksp_type", "cg"], ["ground_ksp_type"])):
        for ranks in (1, 2):
            ran = program.done(ranks, "check", deck, start, *changes, "--", *options)
            found = re.findall(r"the PETSc option -(\w+) was set but never used", ran.stdout)
            expect(sorted(found) == named, f"{changes} {options}: {found}, not {named}", ran)


def main():
    program, deck, folder = Program(sys.argv[1]), sys.argv[2], pathlib.Path(sys.argv[3])
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    # The first makes the run from which the second starts.
    run_checks((check_other_models, check_solver_options, check_foreign_folder, check_lost_output,
                check_run_error, check_full_disk, check_signals), program, deck, folder)


if __name__ == "__main__":
    main()
