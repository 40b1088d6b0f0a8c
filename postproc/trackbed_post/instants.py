"""Which field files a run has: for each instant one file per part of the model.

Parts that a picture or film shows are PARTS unless others are named. Contacts and bonds are lines
within the stones, which hide them, and are drawn only where they are named.
"""
import dataclasses
import pathlib
import re

from trackbed_post import read

PARTS = ("stones", "surfaces", "train", "ground", "solids")
LINES = ("contacts", "bonds")
NAME = re.compile(rf"(?P<instant>.+)_(?P<part>{'|'.join(PARTS + LINES)})\.hdf")


@dataclasses.dataclass(frozen=True)
class Instant:
    """The field files of one time, s, of a run: `files` by their part."""
    time: float
    name: str    # STAGE_WINDOW
    files: dict

    @property
    def stage(self):
        return self.name.rpartition("_")[0]

    def label(self):
        return ", ".join(filter(None, (self.stage, f"{self.time:.6g} s")))


def part_of(path):
    """(STAGE_WINDOW, part) from the name of a field file; of another file, (nothing, its name)."""
    found = NAME.fullmatch(pathlib.Path(path).name)
    return (found["instant"], found["part"]) if found else ("", pathlib.Path(path).stem)


def label_of(path):
    """The label of a field file given alone: stage, if its name has one, and time. The time is that
    which the series beside it or the file states; without both the label is empty."""
    instant, part = part_of(path)
    folder = pathlib.Path(path).resolve().parent.parent
    times = {file.name: time for time, file in read.series(folder, part)}
    time = times.get(pathlib.Path(path).name)
    if time is None:
        time = read.time_in(path)
    return "" if time is None else Instant(time, instant, {}).label()


def of_files(paths):
    """Part -> file of files given one by one, which must be those of one instant."""
    named = [(part_of(path), path) for path in paths]
    first = named[0]
    for other in named[1:]:
        if other[0][0] != first[0][0]:
            raise read.Unreadable(f"{first[1]} and {other[1]} are of different instants: a picture "
                                  "shows the parts of one instant")
    files = {part: path for (_, part), path in named}
    if len(files) < len(named):
        raise read.Unreadable("the same part is given twice: a picture shows one file of each part")
    return files


def available(folder):
    """Part -> its series of (time, file), of those parts that have one."""
    folder = read.folder_of(folder)
    if not folder.is_dir():
        raise read.Unreadable(f"{folder} does not exist or is not a folder")
    found = {part: read.series(folder, part) for part in PARTS + LINES}
    return {part: series for part, series in found.items() if series}


def of_run(folder, parts=None):
    """Instants of a run in order of time with the files of the named parts, or of all in PARTS."""
    found = available(folder)
    if not found:
        raise read.Unreadable(f"{folder} has no field files: run its deck again with "
                              "output.fields=true, and with output.fields_interval=0.01 (s) for "
                              "several instants in each stage")
    chosen = [part for part in PARTS if part in found] if parts is None else list(parts)
    if missing := [part for part in chosen if part not in found]:
        raise read.Unreadable(f"{folder} has no field files of {', '.join(missing)}; it has those "
                              f"of {', '.join(found)}")
    if not chosen:
        raise read.Unreadable(f"{folder} has field files of {', '.join(found)} only: name them "
                              f"with --parts {','.join(found)}")
    together = {}
    for part in chosen:
        for time, file in found[part]:
            if not file.is_file():
                raise read.Unreadable(f"{file} is missing, although the list of its series names "
                                      "it")
            together.setdefault((time, part_of(file)[0]), {})[part] = file
    return [Instant(*key, files) for key, files in sorted(together.items())]


def nearest(all_of_them, time=None):
    """The instant nearest to a time, or the last."""
    return all_of_them[-1] if time is None else min(all_of_them,
                                                    key=lambda each: abs(each.time - time))


def within(all_of_them, stage=None, times=None):
    """The instants of a stage and between two times, s."""
    stages = list(dict.fromkeys(each.stage for each in all_of_them))
    if stage is not None and stage not in stages:
        raise read.Unreadable(f"no field files of a stage {stage}; there are those of "
                              f"{', '.join(stages)}")
    low, high = times or (float("-inf"), float("inf"))
    of_stage = [each for each in all_of_them if stage in (None, each.stage)]
    found = [each for each in of_stage if low <= each.time <= high]
    if not found:
        raise read.Unreadable(f"no field files between {low:g} and {high:g} s; their times go from "
                              f"{of_stage[0].time:.6g} to {of_stage[-1].time:.6g} s")
    return found


def thinned(all_of_them, most):
    """At most so many of them, evenly spread, with the first and the last."""
    count = len(all_of_them)
    if count <= most:
        return all_of_them
    if most == 1:
        return all_of_them[-1:]
    return [all_of_them[round(k * (count - 1) / (most - 1))] for k in range(most)]
