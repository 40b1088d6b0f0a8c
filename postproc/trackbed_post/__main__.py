"""Figures, tables and films of trackbed runs"""
import argparse
import contextlib
import os
import pathlib
import sys

import matplotlib

matplotlib.use("Agg")

from trackbed_post import (arguments, curves, field_sections, films, geometry,  # noqa: E402
                           histogram, kinds, maps, options, overlays, program, read,
                           report, still, sweep, vibration, write)
from trackbed_post.monitor import calibration, passages  # noqa: E402
from trackbed_post.monitor import command as monitor_command  # noqa: E402
from trackbed_post.monitor import forces as monitor_forces  # noqa: E402
from trackbed_post.settlement import command as settlement_command  # noqa: E402
from trackbed_post.settlement import traffic  # noqa: E402
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
    """all figures of a run and tables of its numbers; several runs are drawn as by compare"""
    over = overlays.Overlays(given.laid)
    print_folders(kinds.draw_figures(given.results, given.output, given.kind, given.format, over))
    over.require_drawn()


def compare(given):
    """figures and tables of two runs in the same pictures; of several, the first beside each other
    one, or a folder for each run where this is not possible"""
    figures(given)


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
    print(f"{given.output}: {write.size(given.output.stat().st_size)}")


def draw_still(given):
    """a picture of a field file, of several of the same instant, or of an instant of a run; exit
    code 1 if it has one colour only"""
    still.render(given.sources, given.output, given)


def draw_vibration(given):
    """signal, spectrum and third octaves of a history, beside a measured signal"""
    with drawn(given, write.origin_of([given.results])) as folder:
        vibration.draw_into(given.results, folder, given.quantity, given.place, given.measured,
                            given.cut_off, given.shift)


def draw_geometry(given):
    """longitudinal level in the bands D1, D2, D3 and twist, of files or of runs of a track"""
    runs = [one for one in given.sources if one.is_dir()]
    with drawn(given, write.origin_of(runs) if runs else "") as folder:
        geometry.draw_into(given.sources, folder, geometry.Choices(
            given.twist_base, given.window, given.speed, given.limits, given.irregularity))


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
    with drawn(given, write.origin_or_name(given.source)) as folder:
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
            towards=given.towards, **({"likeness": 0.0} if given.equal else {}))


def find_ballast(given):
    """stiffness of the ballast, and a void, below the sleeper with the sensor"""
    with drawn(given, f"{pathlib.Path(given.signal).name}, {given.deck.name}") as folder:
        calibration.calibrate(given.signal, folder, given.deck, program.find(given.program),
                              given.sensor, given.speed, given.without, given.noise)


def draw_settlement(given):
    """settlement from cycle to cycle or train to train, laws, and a forecast for a traffic"""
    forecast = None
    if given.traffic:
        forecast = settlement_command.Forecast(
            traffic.traffic_from(given.traffic), given.days, given.axles, given.axle_load,
            given.load_exponent)
    elif used := [f"--{name.replace('_', '-')}" for name, default in options.FORECAST.items()
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


# Name -> (what it does, its options).
COMMANDS = {
    "figures": (figures, options.for_figures),
    "compare": (compare, options.for_figures),
    "report": (write_report, options.for_report),
    "film": (film, options.for_film),
    "still": (draw_still, options.for_still),
    "map": (draw_map, options.for_map),
    "vibration": (draw_vibration, options.for_vibration),
    "geometry": (draw_geometry, options.for_geometry),
    "trajectory": (roll_wheels, options.for_trajectory),
    "curve": (draw_curve, options.for_curve),
    "histogram": (draw_histogram, options.for_histogram),
    "sweep": (run_sweep, options.for_sweep),
    "settlement": (draw_settlement, options.for_settlement),
    "monitor": (run_monitor, options.for_monitor),
    "forces": (find_forces, options.for_forces),
    "ballast": (find_ballast, options.for_ballast),
    "list": (list_datasets, options.for_list)}


def parser():
    whole = argparse.ArgumentParser(prog="trackbed_post", description=__doc__)
    commands = whole.add_subparsers(required=True, metavar="COMMAND")
    for name, (run, add_options) in COMMANDS.items():
        one = commands.add_parser(name, help=run.__doc__, description=run.__doc__)
        one.set_defaults(run=run)
        one._negative_number_matcher = arguments.NEGATIVE
        add_options(one)
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
