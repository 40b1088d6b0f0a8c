"""Many passages in one command: a table with a row for each.

A folder of passages has a file passages.csv with a line of names and a line for each passage:
`file` (CSV, WAV or MAT beside it, as for trackbed_post vibration; FILE:COLUMN chooses a column),
and, if known, `begin` (any text that sorts by time, such as 2026-05-01T12:00:00), `speed_m_s`,
`temperature_C` and `reference`: the type of its train, by which others of this type are recognised.
Without passages.csv every signal file of the folder is a passage.

Rows are written as they are found, so that the same command continues a batch that was stopped.
"""
import concurrent.futures
import csv
import dataclasses
import math
import os
import pathlib
import signal
import threading
import time

import numpy as np

from trackbed_post import measured, read
from trackbed_post.monitor import displacement, indicators, trains

SIGNALS = (".csv", ".mat", ".wav")
INDEX = "passages.csv"
FAST = 100.0  # m/s: faster trains are given in km/h
UNKNOWN = "unknown"  # train of a passage that is not recognised
SAME = 1.0    # m/s, largest difference of a given and the recognised speed
LONGER = 4.0  # m, than the reference: the train has other vehicles
COLUMNS = ("file", "begin", "speed_m_s", "temperature_C", "reference")
AHEAD = 64  # passages that wait for a worker: a batch of any length takes little memory


@dataclasses.dataclass(frozen=True)
class Row:
    """What is found of a passage; a number that is not known is not a number."""
    file: str
    begin: str
    temperature_C: float
    train: str
    direction: int
    speed_m_s: float
    similarity: float
    peak_mm: float
    deviation_mm: float
    settlement_mm: float
    misfit: float
    noise_m_s2: float
    acceleration_m_s2: float
    displacement_mm: float
    remarks: str


@dataclasses.dataclass(frozen=True)
class Choices:
    """How passages are evaluated: band of the indicators, m; standard deviation of the sensor's
    noise in a sample, m/s2, if it is known."""
    wavelengths: tuple = indicators.WAVELENGTHS
    noise: float | None = None


NAMES = [field.name for field in dataclasses.fields(Row)]


def number(text, name, file):
    try:
        value = float(text)
    except ValueError:
        raise read.Unreadable(f'{INDEX}: {name} = "{text}" of {file} is no number') from None
    return value if math.isfinite(value) else math.nan


def listed(folder):
    """Lines of passages.csv as dictionaries, or the signal files of the folder."""
    index = folder / INDEX
    if not folder.is_dir():
        raise read.Unreadable(f"{folder} is no folder")
    if not index.is_file():
        files = sorted(path.name for path in folder.iterdir() if path.suffix.lower() in SIGNALS)
        if not files:
            raise read.Unreadable(f"{folder} has neither {INDEX} nor files that end with "
                                  f"{', '.join(SIGNALS)}")
        return [{"file": name} for name in files]
    try:
        text = index.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError:
        raise read.Unreadable(f"{index} is not in UTF-8") from None
    table = csv.DictReader(text.splitlines(), skipinitialspace=True)
    names = table.fieldnames or []
    unknown = [name for name in names if name not in COLUMNS]
    if "file" not in names or unknown:
        raise read.Unreadable(f"{index} has the columns {', '.join(names)}; known are "
                              f"{', '.join(COLUMNS)}, of which file is needed")
    lines = list(table)
    for line in lines:
        if None in line:
            raise read.Unreadable(f"{index}: the line of {line['file']} has more fields than "
                                  "names")
        for name in ("speed_m_s", "temperature_C"):
            number(line.get(name) or "nan", name, line["file"])
    seen = set()
    for name in (line["file"] for line in lines):
        if name in seen:
            raise read.Unreadable(f"{index} lists {name} more than once")
        seen.add(name)
    return [{name: text or "" for name, text in line.items()} for line in lines]


def evaluate(folder, line, library, choices):
    """The Row of a passage. A passage that cannot be evaluated has the reason among its remarks."""
    remarks, found = [], {}
    try:
        measure(measured.acceleration(folder / line["file"]), line, library, choices, found,
                remarks)
    except (read.Unreadable, OSError) as why:
        remarks.append(str(why))
    except (ValueError, IndexError, np.linalg.LinAlgError, MemoryError) as why:
        remarks.append(f"it cannot be evaluated ({type(why).__name__}: {why})")  # the batch goes on
    unknown = {field.name: {str: "", int: 0, float: math.nan}[field.type]
               for field in dataclasses.fields(Row)}
    return Row(**(unknown | found | {
        "file": line["file"], "begin": line.get("begin", ""),
        "temperature_C": number(line.get("temperature_C") or "nan", "temperature_C", line["file"]),
        "remarks": "; ".join(remarks)}))


def measure(signal, line, library, choices, found, remarks):
    """Puts what is found of a signal into `found`, and what is doubtful into `remarks`."""
    remarks += signal.remarks
    rate = signal.rate
    speed = number(line.get("speed_m_s") or "nan", "speed_m_s", line["file"])
    if speed > FAST:
        remarks.append(f"the speed of {speed:g} m/s is given: is it in km/h?")
    if library:
        train = library.identify(signal.values, rate)
        found |= {"train": train.name or UNKNOWN, "direction": train.direction,
                  "similarity": train.similarity}
        if train.name and abs(speed - train.speed) > SAME:
            remarks.append(f"the given speed of {speed:g} m/s is not that of the recognised train, "
                           f"{train.speed:g} m/s")
        if train.name and not math.isfinite(speed):
            speed = train.speed
    if not math.isfinite(speed):
        raise read.Unreadable("the speed is neither given nor recognised")
    found["speed_m_s"] = speed
    done = displacement.reconstruct(signal.values, rate, speed, doubtful=signal.doubtful,
                                    noise=choices.noise)
    if done.reversed:
        remarks.append("the sensor is upside down; its signal was reversed")
    if done.misfit > displacement.TRUSTED:
        remarks.append(f"the misfit of {done.misfit:.3g} is above {displacement.TRUSTED:g}: the "
                       "displacement is wrong, because of low-frequency noise, a step or spike of "
                       "the sensor, its start, or a second train")
    if library and found["train"] != UNKNOWN:
        length = trains.length_of(done.displacement, speed / rate)
        more = length - min(library.lengths_of(found["train"]), key=lambda one: abs(one - length))
        if abs(more) > LONGER:
            remarks.append(f"the train is {abs(more):.0f} m {'longer' if more > 0 else 'shorter'} "
                           "than its reference")
    peak, deviation = done.peak
    found |= {"peak_mm": 1e3 * peak, "deviation_mm": 1e3 * deviation,
              "settlement_mm": 1e3 * done.settlement[0], "misfit": done.misfit,
              "noise_m_s2": done.noise}
    for name, quantity, factor in (("acceleration_m_s2", "acceleration", 1),
                                   ("displacement_mm", "displacement", 1e3)):
        found[name] = factor * indicators.indicator(signal.values, rate, speed,
                                                    choices.wavelengths, quantity, done.at_rest)


# The library of a worker process.
_library = None


def _end_with(parent):
    """Ends this process when its parent has ended, as by SIGKILL."""
    while os.getppid() == parent:
        time.sleep(1)
    os._exit(1)


def _start(library, parent):
    global _library
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C ends the batch, in the main process
    threading.Thread(target=_end_with, args=(parent,), daemon=True).start()
    _library = library


def _work(folder, line, choices):
    return evaluate(folder, line, _library, choices)


def is_of(row, line):
    """Whether a row of the table belongs to this line of the list: same begin, temperature and, if
    it is given, speed."""
    def differ(given, found):
        return not (given == found or math.isnan(given) and math.isnan(found))
    speed = number(line.get("speed_m_s") or "nan", "speed_m_s", line["file"])
    warmth = number(line.get("temperature_C") or "nan", "temperature_C", line["file"])
    return (row["begin"] == line.get("begin", "")
            and not differ(float(f"{warmth:.6g}"), float(row["temperature_C"]))
            and (math.isnan(speed) or float(f"{speed:.6g}") == float(row["speed_m_s"])))


def known_rows(path, lines):
    """Names of the files that the table has already. A last line that is cut off is removed, and so
    are passages that could not be evaluated, and those whose line of the list has changed: they are
    tried again."""
    if not path.is_file():
        return set()
    data = path.read_bytes()
    texts_of = data[:data.rfind(b"\n") + 1].decode("utf-8", "replace").splitlines()
    rows = list(csv.DictReader(texts_of))
    if texts_of and texts_of[0] != ",".join(NAMES):
        raise read.Unreadable(f"{path} is no table of passages of this version; choose another "
                              "folder")
    of_file = {line["file"]: line for line in lines}
    kept = [row for row in rows if row["peak_mm"] not in ("nan", None)
            and (row["file"] not in of_file or is_of(row, of_file[row["file"]]))]
    with path.open("w", encoding="utf-8", newline="") as file:
        table = csv.DictWriter(file, NAMES, lineterminator="\n")
        table.writeheader()
        table.writerows(kept)
    return {row["file"] for row in kept}


def texts(record):
    """Values of a dataclass as they stand in a table."""
    return [f"{value:.6g}" if isinstance(value, float) else value
            for value in dataclasses.astuple(record)]


def batch(folder, path, library, choices=Choices(), workers=1, report=print):
    """Evaluates the passages of a folder that the table `path` does not have yet; their number."""
    folder, lines = pathlib.Path(folder), listed(pathlib.Path(folder))
    known = known_rows(path, lines)
    todo = [line for line in lines if line["file"] not in known]
    count = 0
    with path.open("a", encoding="utf-8", newline="") as file:
        table = csv.writer(file, lineterminator="\n")
        if not path.stat().st_size:
            table.writerow(NAMES)
        for row in evaluated(folder, todo, library, choices, workers):
            table.writerow(texts(row))
            file.flush()
            count += 1
            if count % 1000 == 0:
                report(f"{count} of {len(todo)} passages")
    return count


def evaluated(folder, lines, library, choices, workers):
    """Rows in the order of the lines."""
    if workers < 2:
        for line in lines:
            yield evaluate(folder, line, library, choices)
        return
    with concurrent.futures.ProcessPoolExecutor(workers, initializer=_start,
                                                initargs=(library, os.getpid())) as pool:
        waiting = []
        try:
            for line in lines:
                waiting.append(pool.submit(_work, folder, line, choices))
                if len(waiting) >= AHEAD:
                    yield waiting.pop(0).result()
            for future in waiting:
                yield future.result()
        except KeyboardInterrupt:
            pool.shutdown(cancel_futures=True)
            raise


def references_of(folder, lines, choices):
    """trains.References of the passages whose train and speed are given."""
    found = []
    for line in lines:
        name, speed = line.get("reference"), number(line.get("speed_m_s") or "nan", "speed_m_s",
                                                    line["file"])
        if not name:
            continue
        if name == UNKNOWN:
            raise read.Unreadable(f'{INDEX}: {line["file"]} is a reference of "{UNKNOWN}", which '
                                  "stands for trains that are not recognised; give another name")
        if not math.isfinite(speed):
            raise read.Unreadable(f"{INDEX}: {line['file']} is a reference of {name}, which needs "
                                  "its speed_m_s")
        signal = measured.acceleration(folder / line["file"])
        done = displacement.reconstruct(signal.values, signal.rate, speed,
                                        doubtful=signal.doubtful, noise=choices.noise)
        if done.misfit > displacement.TRUSTED:
            hint = f" (is its speed of {speed:g} m/s in km/h?)" if speed > FAST else ""
            raise read.Unreadable(f"{line['file']} cannot be a reference of {name}: its misfit of "
                                  f"{done.misfit:.3g} is above {displacement.TRUSTED:g}, so that "
                                  f"its displacement is wrong{hint}")
        found.append(trains.Reference.of_passage(name, done.displacement, signal.rate, speed))
    return found


def library_of(folders, references=()):
    """trains.Library of runs of the program and of other references. The name of the train of a run
    is that of the folder, without a number that follows "__"; its displacement is that of the first
    sleeper in the histories."""
    references, names = list(references), set()
    for folder in folders:
        run = read.results(folder)
        whole = pathlib.Path(os.path.abspath(folder)).name
        if whole in names:
            raise read.Unreadable(f"{folder}: the library has another run of this name; runs of "
                                  "one type are named NAME__1, NAME__2")
        names.add(whole)
        train = run.deck.get("train", {})
        if "displacement" not in run.sleeper or not train.get("speed"):
            raise read.Unreadable(f"{folder} has no history of a sleeper (passage.points), or no "
                                  "train of a constant speed")
        if train.get("times"):
            raise read.Unreadable(f"{folder}: a reference needs a constant speed, but train.times "
                                  "changes it")
        values = run.sleeper["displacement"].values
        references.append(trains.Reference.of_passage(
            whole.split("__")[0] or whole, values.reshape(len(values), -1)[:, 0],
            1 / float(np.mean(np.diff(run.time))), float(train["speed"])))
    return trains.Library(references)
