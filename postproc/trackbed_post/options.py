"""Options of the commands, a function for each of them."""
import argparse
import os
import pathlib

from trackbed_post import (arguments, field_film, field_sections, geometry, histogram, instants,
                           kinds, still)
from trackbed_post.monitor import ballast, greens, indicators, regularised

Command = argparse.ArgumentParser

# Options of a forecast with their defaults.
FORECAST = {"days": 365.25, "axles": 1.0, "axle_load": None, "load_exponent": None, "lift": None,
            "force": None, "subgrade": None}


def takes_runs(one: Command, count: str = "+") -> None:
    one.add_argument("results", type=pathlib.Path, nargs=count, metavar="RESULT_DIR",
                     help="folder of a run, with its results.h5")


def writes(one: Command, what: str) -> None:
    one.add_argument("-o", "--output", type=pathlib.Path, required=True, metavar=what)


def takes_program(one: Command) -> None:
    one.add_argument("--program", type=pathlib.Path, metavar="TRACKBED",
                     help="the program; default: build/release/trackbed, or that on the PATH")


def lays_over(one: Command) -> None:
    one.add_argument("--measured", dest="laid", action="append", default=[],
                     metavar="FIGURE=FILE.csv[:X:Y]",
                     help="draws measured or published curves over a figure; may be given "
                     "several times")


def draws(one: Command, over: bool = True) -> None:
    writes(one, "DIR")
    one.add_argument("--format", type=arguments.formats, default=("png",),
                     help=f"one or more of {', '.join(arguments.FORMATS)}, with commas between "
                     "them; csv: what each figure shows")
    if over:
        lays_over(one)


def of_sensor(one: Command) -> None:
    one.add_argument("--noise", type=arguments.noise, metavar="M/S2",
                     help="standard deviation of the sensor's noise in a sample; default: that "
                     "of the quietest part, which contains what the sleeper still moves")


def of_scene(one: Command) -> None:
    one.add_argument("--array", help="by which the first part is coloured; default: of stones "
                     "their speed (velocity), otherwise the first one that is not constant")
    one.add_argument("--view", choices=still.VIEWS,
                     help=f"direction of view; default: {still.VIEW}")
    one.add_argument("--parts", type=arguments.parts, metavar="PART,...",
                     help="of the field files of a run, with commas between them, the one that "
                     "is coloured first; default: those that exist of "
                     f"{', '.join(instants.PARTS)}")
    one.add_argument("--limits", type=arguments.finite, nargs=2, action=arguments.Rising,
                     metavar=("LOW", "HIGH"),
                     help="of the colours; default: smallest and largest value")
    one.add_argument("--x", type=arguments.finite, nargs=2, action=arguments.Rising,
                     metavar=("FROM", "TO"),
                     help="section along the track, m; default: all")


def for_figures(one: Command) -> None:
    takes_runs(one)
    draws(one)
    one.add_argument("--kind", choices=kinds.KINDS, default="",
                     help="draw only figures of this kind; bed_below_train: those of bed without "
                     "the ones that show the end of a stage, when the train has left; default: "
                     "the kinds that suit the deck of the first run")


def for_report(one: Command) -> None:
    takes_runs(one)
    writes(one, "FILE.html")
    one.add_argument("--over", nargs=2, action="append", default=[],
                     metavar=("QUANTITY", "FILE.csv[:X:Y]"),
                     help="draws a measured or published curve over this quantity")
    lays_over(one)
    takes_program(one)
    one.add_argument("--every", type=arguments.positive, metavar="SECONDS",
                     help="writes the report again and again while a run computes; a browser "
                     "loads it as often")


def for_film(one: Command) -> None:
    takes_runs(one)
    writes(one, "FILE.gif|FILE.mp4")
    one.add_argument("--fields", action="store_true",
                     help="draws the field files also of a transition zone; so does each of the "
                     "options below")
    of_scene(one)
    one.add_argument("--stage", metavar="NAME", help="default: all stages")
    one.add_argument("--time", type=arguments.finite, nargs=2, metavar=("FROM", "TO"),
                     help="times of the run, s; default: all")
    one.add_argument("--frames", type=arguments.count, metavar="N",
                     help="largest number of pictures, evenly spread over the field files; "
                     f"default: {field_film.FRAMES}")


def for_still(one: Command) -> None:
    one.add_argument("sources", nargs="+", metavar="FILE.hdf|RESULT_DIR")
    one.add_argument("-o", "--output", required=True, metavar="FILE.png")
    of_scene(one)
    one.add_argument("--time", type=arguments.finite, metavar="S",
                     help="of RESULT_DIR: the field files of the nearest instant; default: those "
                     "with a wheel nearest to the middle of the bed, or the last")


def for_map(one: Command) -> None:
    one.add_argument("source", type=pathlib.Path, metavar="RESULT_DIR|FILE.hdf")
    one.add_argument("--array", help="default: displacement, velocity, force or acceleration, the "
                     "first that the files have")
    one.add_argument("--component", help="draws contours of x, y, z or magnitude of a vector; xx, "
                     "yy, zz, xy, yz, zx of a stress; largest, middle, least of principal values")
    one.add_argument("--part", nargs="+", default=field_sections.PARTS, metavar="PART",
                     help="default: those of stones, ground, solids that have the array")
    one.add_argument("--plane", choices=field_sections.PLANES, default="xz",
                     help="default: %(default)s")
    one.add_argument("--at", type=arguments.finite, default=0.0, metavar="M",
                     help="where the plane crosses the third axis; default: 0")
    one.add_argument("--slice", type=arguments.positive, metavar="M",
                     help="draws all points up to this distance from the plane; default: the "
                     "nearest layer of nodes or elements, or points within half their mean "
                     "distance")
    one.add_argument("--window", type=arguments.finite, nargs=4, metavar=("X0", "X1", "Z0", "Z1"),
                     help="region of the plane, m, of another plane the limits of its axes; "
                     "default: all")
    one.add_argument("--time", type=arguments.finite, metavar="S",
                     help="the nearest instant of a run is drawn; default: that with a wheel "
                     "nearest to the middle of the bed, or the last")
    one.add_argument("--relative-to", type=arguments.finite, metavar="S",
                     help="draws the change since the instant nearest to S, which must be before "
                     "that of --time; of stones also their displacement")
    draws(one)


def for_vibration(one: Command) -> None:
    one.add_argument("results", type=pathlib.Path, metavar="RESULT_DIR")
    one.add_argument("quantity", help="a history such as sleeper/acceleration or wheel/force")
    one.add_argument("--place", type=int, default=-1,
                     help="column of the history (sleeper, wheel, ...), counted from 0, so that "
                          "axle 1 is 0; default: of sleepers on a bed the middle one, otherwise "
                          "that of the largest standard deviation")
    one.add_argument("--measured", default="", metavar="FILE[:COLUMN]", help="CSV, MAT or WAV")
    one.add_argument("--shift", type=arguments.finite, metavar="S",
                     help="is added to the times of --measured, s (0: as they are); default: that "
                          "of the largest correlation of both envelopes")
    one.add_argument("--cut-off", type=float, default=100.0, metavar="HZ",
                     help="cut-off frequency of the low-pass filter of the time history; default: "
                          "%(default)g")
    draws(one, over=False)  # its --measured is the signal beside it


def for_geometry(one: Command) -> None:
    one.add_argument("sources", type=pathlib.Path, nargs="+", metavar="FILE.csv|RESULT_DIR")
    one.add_argument("--twist-base", type=float, nargs="+", default=list(geometry.BASES),
                     metavar="M",
                     help="lengths over which twist is computed, m; default: 3")
    one.add_argument("--window", type=float, default=geometry.WINDOW, metavar="M",
                     help="length of the sliding window of the standard deviation, m; default: "
                          "%(default)g")
    one.add_argument("--speed", type=float, metavar="KMH",
                     help="speed of the line: states sections beyond the limits of --limits or, "
                          "without it, up to 300 km/h, beyond immediate action limits of EN "
                          "13848-5 from memory, of which a template for --limits is written; and, "
                          "above 80 and up to 160 km/h, the track quality class of EN 13848-6")
    one.add_argument("--limits", type=pathlib.Path, metavar="FILE.csv",
                     help="alert, intervention and immediate action limits of the owner of the "
                          "line")
    one.add_argument("--irregularity", action="store_true",
                     help="write the level as irregularity.csv (of two rails irregularity_left.csv "
                          "and irregularity_right.csv) for irregularity.file of a deck")
    draws(one)


def for_trajectory(one: Command) -> None:
    one.add_argument("scan", type=pathlib.Path, metavar="FILE",
                     help="points: CSV with the columns x, y, z and their units (x_mm), or binary "
                     "STL; x along the track, z upwards")
    one.add_argument("--wheel", nargs="+", default=["s1002"], metavar="WHEEL",
                     help="s1002, s1002:hollow:MM (hollow tread of this depth) or a CSV with the "
                     "columns s and growth and their units; default: s1002")
    one.add_argument("--lateral", type=arguments.finite, nargs="+", default=[0.0], metavar="MM",
                     help="y of the tread datum of the wheels, 70 mm from the back of the flange; "
                     "default: 0")
    one.add_argument("--field-side", choices=("+y", "-y"), default="+y",
                     help="where the field side of the wheel is; default: %(default)s")
    one.add_argument("--radius", type=arguments.of_wheel, default=0.46, metavar="M",
                     help="of the wheels; default: %(default)g")
    one.add_argument("--unit", type=arguments.positive, default=1e-3, metavar="M",
                     help="of an STL file; default: %(default)g m")
    one.add_argument("--marks", type=pathlib.Path, metavar="FILE.csv",
                     help="three places or more as scanned (x y z) and in the frame of the track "
                     "(true_x true_y true_z)")
    one.add_argument("--origin", type=arguments.finite, default=0.0, metavar="M",
                     help="x of the scan's origin in the deck; default: 0")
    one.add_argument("--trailing", action="store_true",
                     help="trains run to smaller x of the scan")
    draws(one)


def for_curve(one: Command) -> None:
    one.add_argument("quantity", help="a dataset such as history/rail/displacement")
    takes_runs(one)
    one.add_argument("--place", type=int, default=-1,
                     help="number of its column, from 0, so that axle 1 is 0; default: that of the "
                          "largest range")
    one.add_argument("--over", action="append", default=[], metavar="FILE.csv[:X:Y]",
                     help="a measured or published curve; may be given several times")
    one.add_argument("--shift", type=float, default=0.0, metavar="S",
                     help="offset of the curves of --over along x (m) or time (s)")
    draws(one)


def for_histogram(one: Command) -> None:
    one.add_argument("quantity", help="contact_force, or a dataset such as "
                     "history/sleeper/displacement")
    takes_runs(one)
    one.add_argument("--stage", default="", metavar="NAME",
                     help="rows of the history in this stage, contact forces at its end; default: "
                     "all rows, the last stage")
    one.add_argument("--place", type=int, metavar="K",
                     help="column of the dataset, counted from 0; default: all, of a history")
    one.add_argument("--change", action="store_true",
                     help="of a history: counts the differences from the first number of each "
                     "column")
    one.add_argument("--bins", type=arguments.count, default=histogram.BINS,
                     help="default: %(default)s")
    one.add_argument("--log", action="store_true", help="logarithmic axis of the shares")
    draws(one)


def for_sweep(one: Command) -> None:
    one.add_argument("deck", type=pathlib.Path, help="input file that is run (TOML)")
    one.add_argument("--vary", nargs="+", action="append", required=True,
                     metavar=("PARAMETER", "VALUE"), help="may be given several times; of a deck "
                     "before NAME:PARAMETER, with the name of its file")
    one.add_argument("--before", nargs=2, action="append", default=[],
                     metavar=("DECK", "PARAMETER[=STAGE]"),
                     help="runs this deck first and gives its folder, or the end of its stage, to "
                     "the parameter (bed.cell, start) of the next deck; may be given several "
                     "times, in order")
    one.add_argument("--ranks", type=int, default=1, help="MPI ranks of each run; default: 1")
    takes_program(one)
    one.add_argument("--quantity", default="",
                     help="draw this dataset, e.g. envelope/rail/displacement_min")
    one.add_argument("--place", type=int, default=-1,
                     help="number of the column of --quantity, from 0; default: that of the "
                     "largest range in the first run")
    one.add_argument("--stage", default="", metavar="NAME",
                     help="draws its rows only, over the time since it began")
    draws(one)


def for_settlement(one: Command) -> None:
    takes_runs(one)
    one.add_argument("--begin", type=arguments.positive, default=1.0, metavar="N",
                     help="laws are fitted from this cycle on; default: 1")
    one.add_argument("--traffic", type=pathlib.Path, metavar="FILE.csv",
                     help="trains of a day: columns trains_per_day, axles, axle_load_t")
    one.add_argument("--days", type=arguments.positive, default=FORECAST["days"],
                     help="of the forecast; default: a year")
    one.add_argument("--axles", type=arguments.positive, default=FORECAST["axles"], metavar="K",
                     help="axles that a cycle of the run represents; default: 1")
    one.add_argument("--axle-load", type=arguments.positive, metavar="T", help="of the run, t")
    one.add_argument("--load-exponent", type=arguments.positive, metavar="P",
                     help="an axle of another load counts as (its load over that of the run)^P "
                          "axles; of a settlement that grows with load^a N^b: P = a/b")
    one.add_argument("--lift", type=arguments.positive, metavar="MM",
                     help="draws Shenton's law after a lift of the track in mm")
    one.add_argument("--force", type=arguments.positive, metavar="KN",
                     help="draws the law of Varandas for this force below a sleeper at each axle")
    one.add_argument("--subgrade", type=arguments.subgrade, metavar="SOIL:RATIO:THICKNESS",
                     help="draws the law of Li and Selig for a layer, such as CL:0.4:1.5")
    draws(one)


def for_monitor(one: Command) -> None:
    one.add_argument("passages", type=pathlib.Path, metavar="FOLDER",
                     help="signals (CSV, MAT, WAV) with their list passages.csv")
    one.add_argument("--library", type=pathlib.Path, nargs="+", default=[], metavar="RESULT_DIR",
                     help="runs of known trains, by which type and speed are recognised")
    one.add_argument("--wavelengths", type=float, nargs=2, default=indicators.WAVELENGTHS,
                     metavar="M", help="of the band of the indicators; default: 1 and 0.2 m")
    of_sensor(one)
    one.add_argument("--workers", type=int, default=os.cpu_count() or 1,
                     help="processes side by side; default: %(default)s")
    draws(one)


def for_forces(one: Command) -> None:
    one.add_argument("signal", metavar="FILE[:COLUMN]", help="CSV, MAT or WAV")
    one.add_argument("--kernel", type=pathlib.Path, required=True, metavar="FILE.h5",
                     help="Green's functions of the track, of `trackbed kernel`")
    one.add_argument("--speed", type=float, required=True, metavar="M/S")
    one.add_argument("--axle", type=int, default=1,
                     help="first axle of the bogie, from 1; default: %(default)s")
    one.add_argument("--quantity", choices=greens.QUANTITIES, default="acceleration",
                     help="to which forces are fitted; default: %(default)s")
    one.add_argument("--method", choices=regularised.METHODS, default="tikhonov",
                     help="of the regularisation; default: %(default)s")
    one.add_argument("--criterion", choices=regularised.CRITERIA, default="gcv",
                     help="of its strength; default: %(default)s")
    one.add_argument("--equal", action="store_true",
                     help="equal forces of all wheels of the bogie, for a track that is not the "
                          "one of the Green's functions")
    one.add_argument("--place", choices=("acceleration", "displacement"), default="acceleration",
                     help="by which the place of the train is found; default: %(default)s")
    one.add_argument("--towards", choices=greens.TOWARDS,
                     help="x towards which the train runs; default: larger, but it must be given "
                          "for a train in the opposite order on a track that is not symmetric")
    of_sensor(one)
    draws(one)


def for_ballast(one: Command) -> None:
    one.add_argument("signal", metavar="FILE[:COLUMN]", help="CSV, MAT or WAV")
    one.add_argument("deck", type=pathlib.Path, help="of the track, with the train that passes")
    one.add_argument("--sensor", type=float, required=True, metavar="M",
                     help="x of the sleeper with the sensor")
    one.add_argument("--speed", type=float, required=True, metavar="M/S")
    one.add_argument("--without", nargs="+", choices=ballast.NAMES[2:], default=[],
                     help="parameters that are not fitted: no void, no dip, fixed length")
    of_sensor(one)
    takes_program(one)
    draws(one)


def for_list(one: Command) -> None:
    one.add_argument("file", type=pathlib.Path, metavar="FILE")
