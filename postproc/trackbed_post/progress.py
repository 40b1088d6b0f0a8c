"""How far a run is, and the course of its quantities, from the events of its progress.jsonl
(docs/running.md).
"""
import collections.abc
import fcntl
import json
import os
import pathlib
import time
import typing

import matplotlib.pyplot as plt

from trackbed_post import write

Event = dict[str, typing.Any]
# Keys of events of progress and their labels. Those that a run does not have are left out.
QUANTITIES = {"time_s": "simulated time, s", "speed": "simulated s per s",
              "kinetic_j": "kinetic energy, J", "largest_overlap_m": "largest overlap, m",
              "unbalanced": "net over contact force", "contacts": "contacts",
              "platen_pressure_pa": "pressure of the platen, Pa",
              "ground_kinetic_j": "kinetic energy of the ground, J",
              "first_wheel_force_n": "force of the first wheel, N"}
FILE = "progress.jsonl"
SPAN = 30  # largest over smallest value from which on an axis is logarithmic
UNITS = (("h", 3600, 2), ("min", 60, 2), ("s", 1, 0))  # of the wall time, from this many on


def events_of(folder: pathlib.Path) -> list[Event]:
    """The lines of the file, oldest first; a line that is only partly written is left out."""
    path = folder / FILE
    if not path.is_file():
        return []
    found = []
    for line in path.read_text(encoding="utf-8", errors="replace").splitlines():
        try:
            event = json.loads(line)
        except ValueError:
            continue
        if isinstance(event, dict) and isinstance(event.get("unix_time_s"), (int, float)):
            found.append(event)
    return found


def computes(folder: pathlib.Path) -> bool:
    """A run that computes holds the lock of its folder. The test takes it for a moment."""
    try:
        lock = os.open(folder / ".lock", os.O_RDONLY | os.O_CLOEXEC)
    except OSError:
        return False
    try:
        fcntl.flock(lock, fcntl.LOCK_SH | fcntl.LOCK_NB)
        return False
    except BlockingIOError:
        return True
    finally:
        os.close(lock)


def _clock(seconds: float) -> str:
    minutes, rest = divmod(round(max(seconds, 0)), 60)
    return f"{minutes // 60}:{minutes % 60:02}:{rest:02}"


def _last(events: collections.abc.Sequence[Event], kind: str) -> Event:
    return next((one for one in reversed(events) if one.get("event") == kind), {})


def warnings_of(folder: pathlib.Path) -> list[str]:
    """Warnings up to now; the last command repeats those of the ones before."""
    found: list[str] = []
    for event in events_of(folder):
        if event.get("event") == "begin":
            found.clear()
        elif event.get("event") == "warning":
            found.append(str(event.get("message", "")))
    return found


def _part_done(event: Event) -> str:
    """Of the windows of its stage, in brackets; empty if their number is not known."""
    at_most = event.get("windows_at_most", 0)
    return f" ({100 * event.get('window', 0) / at_most:.0f} % of its windows)" if at_most else ""


def before_stage(folder: pathlib.Path, number: int) -> str:
    """Why the histories of a run have no row of a stage, counted from 0: whether it computes, and
    where it is or was, in words."""
    events = events_of(folder)
    last = events[-1] if events else {}
    at = last.get("stage_number", 0)
    where = f"stage {last.get('stage')}, {at} of {last.get('stages')}{_part_done(last)}"
    there = at > number
    if computes(folder):
        return "the run is computing" + (
            "" if not events else f" it ({where}), and its histories are written later" if there
            else f" and has not come to it ({where})")
    ending = "was stopped"
    if events:
        ending = {"failed": "failed"}.get(str(last.get("outcome")), ending) \
            if last.get("event") == "end" else "was killed"
    return f"the run {ending} " + ("in it, before its histories were written" if there
                                   else "before it")


def facts_of(folder: pathlib.Path) -> dict[str, str]:
    """Names and texts of the present state; empty without events."""
    events = events_of(folder)
    if not events:
        return {}
    now, last, end = time.time(), events[-1], _last(events, "end")
    found = {}
    if computes(folder):
        found["run"] = "computes"
    elif last is end:
        message = f": {end['message']}" if end.get("message") else ""
        found["run"] = f"{end.get('outcome', 'ended')}{message}"
    else:
        found["run"] = "was killed"
    found["stage"] = (f"{last.get('stage_number')} of {last.get('stages')}, "
                      f"{last.get('stage')}{_part_done(last)}")
    found["simulated time, s"] = f"{last.get('time_s', 0):.6g}"
    command = max(k for k, one in enumerate(events) if k == 0 or one.get("event") == "begin")
    present = _last(events[command:], "progress")
    if computes(folder) and present:
        found["remaining if stages have their full duration, h:mm:ss"] = _clock(
            present.get("remaining_s", 0))
    found["last event, h:mm:ss ago"] = _clock(now - last["unix_time_s"])
    if saved := _last(events, "checkpoint"):
        found["last checkpoint"] = (f"{saved.get('file')} at {saved.get('time_s', 0):.6g} s, "
                                    f"{_clock(now - saved['unix_time_s'])} ago")
    return found


def draw_into(path: pathlib.Path, made: write.Folder) -> None:
    """Simulated time and the quantities of the events over the time since the run began; the begin
    of each stage is a line, that of each command a thick one."""
    events = events_of(path)
    shown = [one for one in events if one.get("event") == "progress"]
    if len(shown) < 2:
        made.remarks.append("There is no figure of the progress yet.")
        return
    begin, lasted = events[0]["unix_time_s"], events[-1]["unix_time_s"] - events[0]["unix_time_s"]
    unit, seconds = next((name, each) for name, each, least in UNITS if lasted >= least * each)
    keys = [key for key in QUANTITIES if any(key in event for event in shown)]
    rows = (len(keys) + 1) // 2
    figure, panels = plt.subplots(rows, 2, figsize=(11, 2.2 * rows), squeeze=False,
                                  constrained_layout=True)
    panels = list(panels.flat)
    for panel, key in zip(panels, keys):
        points = [(one["unix_time_s"], one[key]) for one in shown if key in one]
        values = [value for _, value in points]
        panel.plot([(t - begin) / seconds for t, _ in points], values, ".-", markersize=3,
                   linewidth=1)
        if min(values) > 0 and max(values) > SPAN * min(values):
            panel.set_yscale("log")
        for event in events:
            if event.get("event") in ("begin", "stage"):
                panel.axvline((event["unix_time_s"] - begin) / seconds, color="0.7", zorder=0,
                              linewidth=2 if event["event"] == "begin" else 0.7)
        panel.set(xlabel=f"time since the run began, {unit}", ylabel=QUANTITIES[key])
    for panel in panels[len(keys):]:
        panel.remove()
    made.picture("progress", figure)
