"""Runs of the study crossing, and the values that tell them apart."""
import numpy as np

from . import crossing_jenkins as jenkins
from . import crossing_scanned as scanned
from . import crossing_stones as stones
from .study import Run, deck_of

from trackbed_post.monitor import ballast  # noqa: I001 (found by .study)

DECK = "track/crossing.toml"
RATE, SPEED, SENSOR = 5000.0, 50.0, 18.0  # Hz, m/s, m
NOISE = (1e-3, 1e-2)
COACHES, FEWER = ("train.vehicles=[" + ", ".join(count * ['"coach"']) + "]" for count in (6, 5))
OTHER = 56.74  # m/s: between two steps of the search
JOINTS = {"short": (0.7e-3, 0.8), "middle": (1.5e-3, 1.2), "long": (3e-3, 2.0)}  # m: depth, length
# Panels: stiffness of pads, N/m (the thesis: nominal, 60E1, UIC60), of ballast springs, N/m.
PANELS = {f"pad {pad:g}, ballast {bed:g} MN/m": (1e6 * pad, 1e6 * bed)
          for pad in (60, 120, 1200) for bed in (12, 24)}
STIFFNESS = deck_of(DECK)["ballast"]["stiffness"]
ZONE = "{from=16.5, to=19.5, rail=3}"
BEDS = {"half": 0.5, "as in the deck": 1.0, "double": 2.0}  # of the three sleepers at the sensor
VOIDS = tuple(1e-4 * gap for gap in (2, 2.5, 3, 3.5, 4, 4.5, 5, 6, 7, 8))  # m
FREE = tuple(name for name in ballast.NAMES if name != "void")
TRANSITION, FARTHEST = 1.0, 6  # m; sleepers on each side that differ
EVEN = "irregularity.kind=none"
DECAY = 0.03  # s: the thesis says that responses have decayed then

FORMS = {"short": {"dips": 8, "panel_dips": 3, "seeds": 2, "joints": ("middle",),
                   "beds": ("half",), "bed_seeds": 1, "voids": (), "sound": 0, "stones": False,
                   "scanned": scanned.CASES[:1]},
         "full": {"dips": 20, "panel_dips": 8, "seeds": 10, "joints": tuple(JOINTS),
                  "beds": tuple(BEDS), "bed_seeds": 10, "voids": VOIDS, "sound": 7, "stones": True,
                  "scanned": scanned.CASES}}


def dips(count):
    """(depth, length), m, of dips at random."""
    random = np.random.default_rng(1)
    return [(random.uniform(2e-4, 4e-3), random.uniform(0.6, 2.0)) for _ in range(count)]


def of_dip(depth, length):
    return (f"irregularity.depth={depth:.4g}", f"irregularity.length={length:.4g}")


def panel_run(number, dip):
    return f"panel_{number + 1}_{dip + 1}"


def bed_run(name):
    return f"bed_{name.split()[0]}"


def bed_words(name):
    return f"track.zone=[{ZONE}, {{from=17.1, to=18.9, bed={BEDS[name]}}}]"


def gaussian_words(ratio):
    """Ballast at the sensor that is `ratio` as stiff, with the transition that is fitted."""
    spacing = deck_of(DECK)["track"]["spacing"]
    zones = [ZONE]
    for number in range(-FARTHEST, FARTHEST + 1):
        at = SENSOR + number * spacing
        factor = ratio**np.exp(-((at - SENSOR) / TRANSITION)**2 / 2)
        zones.append(f"{{from={at - spacing / 2:.6g}, to={at + spacing / 2:.6g}, "
                     f"bed={factor:.6g}}}")
    return f"track.zone=[{', '.join(zones)}]"


def bias_runs():
    """What may cause the error at the double stiffness: the dip and the form of the transition."""
    return {"even": (bed_words("double"), EVEN),
            "smooth": (gaussian_words(BEDS["double"]), EVEN)}


def runs(form):
    chosen = FORMS[form]
    found = [Run("known", DECK, (COACHES,)), Run("other", DECK, (COACHES, f"train.speed={OTHER}")),
             Run("fewer", DECK, (FEWER,)), Run("single", DECK)]
    found += [Run(f"dip_{number + 1}", DECK, of_dip(*dip))
              for number, dip in enumerate(dips(chosen["dips"]))]
    found += [Run(f"joint_{name}", DECK, of_dip(*JOINTS[name])) for name in chosen["joints"]]
    found += [Run(panel_run(number, k), DECK, (f"pad.stiffness={pad}", f"ballast.stiffness={bed}",
                                               *of_dip(*dip)))
              for number, (pad, bed) in enumerate(PANELS.values())
              for k, dip in enumerate(dips(chosen["panel_dips"]))]
    found += [Run(bed_run(name), DECK, (bed_words(name),)) for name in chosen["beds"]]
    if "double" in chosen["beds"]:
        found += [Run(f"bed_double_{name}", DECK, words) for name, words in bias_runs().items()]
    found += [Run(f"void_{k + 1}", DECK,
                  (f"track.zone=[{ZONE}, {{from=17.7, to=18.3, gap={void}}}]",))
              for k, void in enumerate(chosen["voids"])]
    found += jenkins.runs(DECK)
    found += scanned.runs(chosen["scanned"])
    return found + (stones.runs() if chosen["stones"] else [])
