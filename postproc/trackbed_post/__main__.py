"""Figures, tables and films of trackbed runs"""
import argparse
import contextlib
import os
import pathlib
import sys

import matplotlib

matplotlib.use("Agg")

from trackbed_post import (arguments, curves, field_film, field_sections, films,  # noqa: E402
                           geometry, histogram, instants, kinds, maps, overlays, program,
                           read, report, still, sweep, vibration, write)
from trackbed_post.monitor import command as monitor_command  # noqa: E402
from trackbed_post.monitor import (ballast, calibration, greens, indicators,  # noqa: E402
                                   passages, regularised)
from trackbed_post.monitor import forces as monitor_forces  # noqa: E402
from trackbed_post.settlement import command as settlement_command  # noqa: E402
from trackbed_post.settlement import laws, traffic  # noqa: E402
from trackbed_post.trajectory import command as trajectory_command  # noqa: E402


def print_folders(folders):
    for folder in folders:
        for remark in folder.remarks:
            print(remark)
        for path in folder.pictures:
            print(path)
        for table in folder.tables:
            print(table, end="")


@contextlib.contextmanager
def drawn(given, origin):
    """The folder into which a command draws; prints what was written."""
    over = overlays.Overlays(getattr(given, "laid", ()))
    folder = write.Folder(given.output, origin, given.format, over)
    yield folder
    print_folders([folder])
    over.require_drawn()


def figures(given):
    """figures and a table of numbers of one run, or of several side by side"""
    over = overlays.Overlays(given.laid)
    print_folders(kinds.draw_figures(given.results, given.output, given.kind, given.format, over))
    over.require_drawn()


def film(given):
    """a film (GIF) of a train over a transition zone, of two runs the levels of both; of any other
    run the field files as pictures of the model in space (GIF, MP4)"""
    films.write_film(given)


def write_report(given):
    """one HTML file of a run, or of several side by side"""
    choices = report.Choices(given.over, given.laid, given.program)
    if given.every:
        report.follow(given.results, given.output, choices, given.every)
    else:
        report.write_report(given.results, given.output, choices)
    print(f"{given.output}: {given.output.stat().st_size / 1e6:.1f} MB")


def draw_still(given):
    """a picture of a field file, of several of the same instant, or of an instant of a run; exit
    code 1 if it has one colour only"""
    still.render(given.sources, given.output, given)


def draw_vibration(given):
    """signal, spectrum and third octaves of a history, beside a measured signal"""
    with drawn(given, write.origin_of([given.results])) as folder:
        vibration.draw_into(given.results, folder, given.quantity, given.place, given.measured,
                            given.cut_off)


def draw_geometry(given):
    """longitudinal level in the bands D1, D2, D3 and twist, of files or of runs of a track"""
    runs = [one for one in given.sources if one.is_dir()]
    with drawn(given, write.origin_of(runs) if runs else "") as folder:
        geometry.draw_into(given.sources, folder, given.twist_base, given.window, given.speed,
                           given.irregularity)


def roll_wheels(given):
    """paths of wheels over a scanned rail (CSV, STL), as files of irregularity"""
    choices = trajectory_command.Choices(
        tuple(given.wheel), tuple(1e-3 * y for y in given.lateral),
        1 if given.field_side == "+y" else -1, given.radius, given.unit, given.marks, given.origin,
        given.trailing)
    with drawn(given, given.scan.name) as folder:
        trajectory_command.trajectory(given.scan, folder, choices)


def draw_curve(given):
    """a quantity of runs over time or x, beside measured or published curves (CSV)"""
    with drawn(given, write.origin_of(given.results)) as folder:
        curves.draw_into(given.results, folder, given.quantity, given.place, given.over,
                         given.shift)


def draw_histogram(given):
    """how often values of a dataset occur, of several runs over each other"""
    choices = histogram.Choices(given.stage, given.place, given.change, given.bins, given.log)
    with drawn(given, write.origin_of(given.results)) as folder:
        histogram.draw_into(given.results, folder, given.quantity, choices)


def draw_map(given):
    """arrows or contours of an array of field files, in a plane through the model"""
    choices = field_sections.Choices(given.array, given.component, tuple(given.part), given.plane,
                                     given.at, given.slice, given.window, given.time,
                                     given.relative_to)
    with drawn(given, maps.origin_of(given.source)) as folder:
        maps.draw_into(given.source, folder, choices)


def run_sweep(given):
    """runs a deck with several values of parameters; mean and band over the seeds"""
    done, ending = sweep.run_all(*sweep.of_options(given))
    if done:
        origin = write.origin_of([case.folder for case in done])
        with drawn(given, origin) as folder:
            sweep.write_results(done, folder, given.quantity, given.place, given.stage)
    if ending:
        why = read.Unreadable("not all runs have finished")
        why.code = ending
        raise why


def run_monitor(given):
    """displacement, indicators and train of each passage that one accelerometer recorded"""
    choices = passages.Choices(tuple(given.wavelengths), given.noise)
    with drawn(given, write.origin_of(given.library) if given.library else "") as folder:
        monitor_command.monitor(given.passages, folder, given.library, choices, given.workers)


def find_forces(given):
    """wheel forces and irregularity of the running surface from the acceleration of a sleeper"""
    with drawn(given, f"{pathlib.Path(given.signal).name}, {given.kernel.name}") as folder:
        monitor_forces.forces(
            given.signal, folder, given.kernel, given.speed, first=given.axle - 1,
            quantity=given.quantity, method=given.method, criterion=given.criterion,
            known_noise=given.noise, refined=given.place == "acceleration",
            **({"likeness": 0.0} if given.equal else {}))


def find_ballast(given):
    """stiffness of the ballast, and a void, below the sleeper with the sensor"""
    with drawn(given, f"{pathlib.Path(given.signal).name}, {given.deck.name}") as folder:
        calibration.calibrate(given.signal, folder, given.deck, program.find(given.program),
                              given.sensor, given.speed, given.without, given.noise)


# Options of a forecast with their defaults.
FORECAST = {"days": 365.25, "axles": 1.0, "axle_load": None, "load_exponent": None, "lift": None,
            "force": None, "subgrade": None}


def draw_settlement(given):
    """settlement from cycle to cycle or train to train, laws, and a forecast for a traffic"""
    forecast = None
    if given.traffic:
        forecast = settlement_command.Forecast(
            traffic.traffic_from(given.traffic), given.days, given.axles, given.axle_load,
            given.load_exponent)
    elif used := [f"--{name.replace('_', '-')}" for name, default in FORECAST.items()
                  if getattr(given, name) != default]:
        raise read.Unreadable(f"{', '.join(used)}: for a forecast, which needs --traffic")
    if given.lift is not None and given.axle_load is None:
        raise read.Unreadable("--lift (Shenton's law) needs the axle load: give --axle-load")
    with drawn(given, write.origin_of(given.results)) as folder:
        settlement_command.settlement(given.results, folder, given, forecast)


def list_datasets(given):
    """names, shapes, units and meanings of all datasets of an HDF5 file"""
    for name, item in read.datasets(given.file).items():
        print(f"{name:44} {str(item.values.shape):16} {item.unit:8} {item.meaning}")


def parser():
    whole = argparse.ArgumentParser(prog="trackbed_post", description=__doc__)
    commands = whole.add_subparsers(required=True, metavar="COMMAND")

    def command(name, run):
        one = commands.add_parser(name, help=run.__doc__, description=run.__doc__)
        one.set_defaults(run=run)
        one._negative_number_matcher = arguments.NEGATIVE
        return one

    def takes_runs(one, count="+"):
        one.add_argument("results", type=pathlib.Path, nargs=count, metavar="RESULT_DIR",
                         help="folder of a run, with its results.h5")

    def writes(one, what):
        one.add_argument("-o", "--output", type=pathlib.Path, required=True, metavar=what)

    def takes_program(one):
        one.add_argument("--program", type=pathlib.Path, metavar="TRACKBED",
                         help="default: build/release/trackbed, or that on the PATH")

    def lays_over(one):
        one.add_argument("--measured", dest="laid", action="append", default=[],
                         metavar="FIGURE=FILE.csv[:X:Y]",
                         help="draws measured or published curves over a figure; may be given "
                         "several times")

    def draws(one, over=True):
        writes(one, "DIR")
        one.add_argument("--format", type=arguments.formats, default=("png",),
                         help=f"one or more of {', '.join(arguments.FORMATS)}, with commas between "
                         "them; csv: what each figure shows")
        if over:
            lays_over(one)

    def of_sensor(one):
        one.add_argument("--noise", type=arguments.noise, metavar="M/S2",
                         help="standard deviation of the sensor's noise in a sample; default: that "
                         "of the quietest part, which contains what the sleeper still moves")

    def of_scene(one):
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

    for name in ("figures", "compare"):  # two names of one command
        one = command(name, figures)
        takes_runs(one)
        draws(one)
        one.add_argument("--kind", choices=kinds.KINDS, default="",
                         help="draw only figures of this kind; default: the kinds that suit the "
                         "deck of the first run")
    one = command("report", write_report)
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
    one = command("film", film)
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
    one = command("still", draw_still)
    one.add_argument("sources", nargs="+", metavar="FILE.hdf|RESULT_DIR")
    one.add_argument("-o", "--output", required=True, metavar="FILE.png")
    of_scene(one)
    one.add_argument("--time", type=arguments.finite, metavar="S",
                     help="of RESULT_DIR: the field files of the nearest instant; default: the "
                     "last")
    one = command("map", draw_map)
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
                     help="the nearest instant of a run is drawn; default: the last")
    one.add_argument("--relative-to", type=arguments.finite, metavar="S",
                     help="draws the change since the nearest earlier instant, of stones also "
                     "their displacement")
    draws(one)
    one = command("vibration", draw_vibration)
    one.add_argument("results", type=pathlib.Path, metavar="RESULT_DIR")
    one.add_argument("quantity", help="a history such as sleeper/acceleration or wheel/force")
    one.add_argument("--place", type=int, default=-1,
                     help="column of the history (sleeper, wheel, ...), counted from 0, so that "
                          "axle 1 is 0; default: the one with the largest standard deviation")
    one.add_argument("--measured", default="", metavar="FILE[:COLUMN]", help="CSV, MAT or WAV")
    one.add_argument("--cut-off", type=float, default=100.0, metavar="HZ",
                     help="cut-off frequency of the low-pass filter of the time history; default: "
                          "%(default)g")
    draws(one, over=False)  # its --measured is the signal beside it
    one = command("geometry", draw_geometry)
    one.add_argument("sources", type=pathlib.Path, nargs="+", metavar="FILE.csv|RESULT_DIR")
    one.add_argument("--twist-base", type=float, nargs="+", default=list(geometry.BASES),
                     metavar="M",
                     help="lengths over which twist is computed, m; default: 3")
    one.add_argument("--window", type=float, default=geometry.WINDOW, metavar="M",
                     help="length of the sliding window of the standard deviation, m; default: "
                          "%(default)g")
    one.add_argument("--speed", type=float, metavar="KMH",
                     help="speed of the line, at most 300 km/h: states sections beyond the "
                          "immediate action limits of EN 13848-5, and, above 80 and up to 160 "
                          "km/h, the track quality class of EN 13848-6")
    one.add_argument("--irregularity", action="store_true",
                     help="write the level as irregularity.csv (of two rails irregularity_left.csv "
                          "and irregularity_right.csv) for irregularity.file of a deck")
    draws(one)
    one = command("trajectory", roll_wheels)
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
    one = command("curve", draw_curve)
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
    one = command("histogram", draw_histogram)
    one.add_argument("quantity", help="contact_force, or a dataset such as "
                     "history/sleeper/displacement")
    takes_runs(one)
    one.add_argument("--stage", default="", metavar="NAME",
                     help="rows of the history in this stage, contact forces at its end; default: "
                     "all rows, the last stage")
    one.add_argument("--place", type=int, metavar="K",
                     help="column of the dataset, counted from 0; default: all")
    one.add_argument("--change", action="store_true",
                     help="of a history: counts the differences from the first number of each "
                     "column")
    one.add_argument("--bins", type=arguments.count, default=histogram.BINS,
                     help="default: %(default)s")
    one.add_argument("--log", action="store_true", help="logarithmic axis of the shares")
    draws(one)
    one = command("sweep", run_sweep)
    one.add_argument("deck", type=pathlib.Path)
    one.add_argument("--vary", nargs="+", action="append", required=True,
                     metavar=("PARAMETER", "VALUE"), help="may be given several times; of a deck "
                     "before NAME:PARAMETER, with the name of its file")
    one.add_argument("--before", nargs=2, action="append", default=[],
                     metavar=("DECK", "PARAMETER[=STAGE]"),
                     help="runs this deck first and gives its folder, or the end of its stage, to "
                     "the parameter (bed.cell, start) of the next deck; may be given several "
                     "times, in order")
    one.add_argument("--ranks", type=int, default=1)
    takes_program(one)
    one.add_argument("--quantity", default="",
                     help="draw this dataset, e.g. envelope/rail/displacement_min")
    one.add_argument("--place", type=int, default=-1)
    one.add_argument("--stage", default="", metavar="NAME",
                     help="draws its rows only, over the time since it began")
    draws(one)
    one = command("settlement", draw_settlement)
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
    one = command("monitor", run_monitor)
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
    one = command("forces", find_forces)
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
    of_sensor(one)
    draws(one)
    one = command("ballast", find_ballast)
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
    one = command("list", list_datasets)
    one.add_argument("file", type=pathlib.Path, metavar="FILE")
    return whole




CONTINUES = (run_monitor, run_sweep)
STOPPED = 3  # exit code of a command that is ended by Ctrl-C


def main(words=None):
    given = parser().parse_args(words)
    try:
        given.run(given)
        sys.stdout.flush()
    except read.Unreadable as why:
        print(why, file=sys.stderr)
        return why.code
    except KeyboardInterrupt:
        print("stopped" + ("; the same command continues it" if given.run in CONTINUES else ""),
              file=sys.stderr)
        return STOPPED
    except OSError as error:
        if isinstance(error, BrokenPipeError):  # the reader has ended, as `| head` does
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
            return 0
        print(error, file=sys.stderr)
        return 4 if error.errno in write.DISK else 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
