#!/usr/bin/env python3
"""A jump over cycles of load, its results and the command `settlement`.

    settlement.py PROGRAM SOURCE_FOLDER FOLDER
"""
import csv
import pathlib
import shutil
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from program import Program, expect, summary  # noqa: E402

CYCLES, JUMP, PERIOD = 8, 12, 0.02
DECK = ("stage.load.settlement=0", "stage.passage.kind=jump", "stage.passage.duration=0.6",
        f"stage.passage.cycles={JUMP}", "stage.passage.load=2e3", "jump.from=load",
        "jump.cycles=4", f"jump.period={PERIOD}", "jump.exponent=1")


def main():
    program, source, folder = Program(sys.argv[1]), pathlib.Path(sys.argv[2]), pathlib.Path(
        sys.argv[3])
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    ran = program.done(1, "run", source / "tests" / "restart" / "tiny.toml", "-o", folder / "run",
                       *DECK)
    expect(f"jump from cycle {CYCLES} to {CYCLES + JUMP}" in ran.stdout, "no jump", ran)
    wanted = float(ran.stdout.partition("should settle by ")[2].split()[0])

    def settlement(*words):
        return subprocess.run([sys.executable, source / "postproc", "settlement", folder / "run",
                               "-o", folder / "drawn", *words], capture_output=True, text=True,
                              check=False)
    traffic = folder / "traffic.csv"
    traffic.write_text("trains_per_day,axles,axle_load_t\n10,100,20\n", encoding="utf-8")
    drawn = settlement("--traffic", traffic, "--axle-load", "20", "--lift", "10", "--force", "50",
                       "--subgrade", "CL:0.4:1.5")
    expect(drawn.returncode == 0, "settlement", drawn)
    with open(folder / "drawn" / "settlement.csv", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    counts = [int(row["cycles"]) for row in rows]
    expect(counts == [*range(CYCLES + 1), CYCLES + JUMP], f"cycles {counts}", drawn)
    jump = float(rows[-1]["mean_mm"]) - float(rows[-2]["mean_mm"])
    # It ends after the first cycle in which the sleepers are there: friction fell in those before.
    took = summary(folder / "run")["stages"][-1]["duration_s"]
    expect(took > 3 * PERIOD, f"the jump took {took} s", ran)
    expect(0.9 * wanted < jump < 1.5 * wanted, f"the jump settles by {jump} mm, not {wanted}",
           drawn)
    for words in ("8 of them computed", "365.25 days, 7.3 million tonnes", "Shenton: ",
                  "Varandas: ", "Li and Selig, 1.5 m of CL: "):
        expect(words in drawn.stdout, f"no {words!r}", drawn)
    for words, sentence in ((("--lift", "10"), "needs --traffic"),
                            (("--subgrade", "XX:0.4:1"), "give SOIL:RATIO:THICKNESS")):
        drawn = settlement(*words)
        expect(drawn.returncode == 2 and sentence in drawn.stderr, sentence, drawn)

    drawn = settlement("--begin", "7")
    expect(drawn.returncode == 0 and "too few to fit" in drawn.stdout, "few cycles", drawn)


if __name__ == "__main__":
    main()
