"""A synthetic results.h5: known functions in the layout of the program."""
import h5py
import numpy as np

SPEED, AXLES, EDGE = 20.0, (0.0, 2.5, 8.0, 10.5), 2.0  # m/s, m, m: v/L_c 2.5 Hz, v/L_w 8 Hz
DECK = """
[bed]
grading = "custom"
[load]
speed = {speed}
axles = {axles}
[sleepers]
spacing = 0.6
[[ground.block]]
name = "structure"
young = 30e9
present = true
outline = [0.0, 0.0, {edge}, 0.0, {edge}, -2.0, 0.0, -2.0]
[[ground.block]]
name = "wedge"
young = 500e6
present = {wedge}
outline = [{edge}, 0.0, 6.0, 0.0, {edge}, -2.0]
[[stage]]
name = "fill"
kind = "fill"
[[stage]]
name = "compact"
kind = "compact"
[[stage]]
name = "sleepers"
kind = "sleepers"
[[stage]]
name = "load"
kind = "load"
[[stage]]
name = "passage"
kind = "passage"
"""


def ground_displacement(x, wedge):
    """Downwards, m: 0.02 mm on the structure, exponentially to 2 mm in 3 m (wedge) or 0.5 m."""
    way = np.maximum(x - EDGE, 0)
    return -(0.02e-3 + 1.98e-3 * (1 - np.exp(-way / (1.0 if wedge else 0.2))))


def ground_stress(x, wedge):
    """Stress, Pa: 100 kPa on the structure, less beyond."""
    return np.where(x <= EDGE, -100e3, -80e3 if wedge else -30e3)


def histories(time, x):
    """Motion of sleepers: `displacement` 1 mm at 2 Hz, `acceleration` 3 m/s^2 at 10 Hz plus 50 at
    300 Hz, `seat_force` a pulse of -50 kN per axle, passing at SPEED."""
    t = time[:, None]
    ones = np.ones((1, len(x)))
    way = SPEED * t - x[None, :]
    return {
        "displacement": (1e-3 * np.sin(2 * np.pi * 2 * t) * ones, "m"),
        "velocity": (np.cos(2 * np.pi * 2 * t) * ones, "m/s"),
        "acceleration": ((3 * np.sin(2 * np.pi * 10 * t) + 50 * np.sin(2 * np.pi * 300 * t)) * ones,
                         "m/s^2"),
        "seat_force": (-sum(50e3 * np.exp(-((way - 3 - axle) / 0.5)**2) for axle in AXLES), "N"),
        "reaction": (7e3 * np.ones((len(time), len(x))), "N"),
    }


# Two cells: the first with three times the stones of the second.
REGION = {"porosity": (0.4, 0.5), "bulk_density": (1500.0, 1300.0), "stones": (30.0, 10.0),
          "coordination": (6.0, 4.0), "contacts": (90.0, 20.0), "contact_force": (100.0, 45.0),
          "stress": ([[-1e3, -2e3, -9e3, 0, 0, 0]], [[-1e3, -2e3, -7e3, 0, 0, 0]]),
          "fabric": ([[0.3, 0.3, 0.4, 0, 0, 0]], [[0.2, 0.2, 0.6, 0, 0, 0]])}


SENSOR = (("displacement", 1e-3, "m"), ("velocity", 1e-2, "m/s"), ("acceleration", 1.0, "m/s2"))
SIEVED = np.array([[0.03, 1.0], [0.04, 3.0]])
# Two places along, three across; no stones in the last.
SURFACE = [[0.5, -1.0, 0.1], [1.5, -1.0, 0.3], [0.5, 0.0, 0.5], [1.5, 0.0, 0.5],
           [0.5, 1.0, float("nan")], [1.5, 1.0, float("nan")]]
# A fragment of 12 mm and fines.
WHOLE = np.array([[0, 1, 0, 1.0, 0, 0.1, 50.0, 0.4, 0], [1, 2, 0, 1.1, 0, 0.2, 90.0, 0.9, 0.2]])
BROKEN = np.array([[0.5, 2, 3, 0, 1, 1.2, 0, 0.1, 2e5, 9e5, 1e-3]])
BREAKS = np.array([[0.01, 3, 90, 0.4, 0, 0.3, 0.012, 2.4e-3, 800, 1e-3, 1e-6],
                   [0.05, 5, -1, 0.5, 0, 0.3, 0.004, 9e-5, 90, 1e-4, 0]])
GRADING = np.array([[0.0224, 0, 0, 3], [0.035, 20, 10, 30], [0.063, 100, 100, 100]])


def store(path, datasets, **attributes):
    """Writes an HDF5 file of {name: (values, unit)} with attributes of the file."""
    with h5py.File(path, "w") as file:
        file.attrs.update(attributes)
        for name, (values, unit) in datasets.items():
            file[name] = values
            file[name].attrs["units"], file[name].attrs["long_name"] = unit, "made for a test"


def write(folder, wedge=True, ground=True):
    """Writes folder/results.h5 and returns the folder."""
    folder.mkdir(parents=True, exist_ok=True)
    x, nodes = np.arange(0.3, 9.0, 0.6), np.linspace(0, 9, 91)
    settle, passage = np.arange(0, 0.1, 1e-3), 0.1 + np.arange(0, 2.0, 1e-3)
    time = np.concatenate([settle, passage])
    chains = np.array([[1.0, 0.1, 1.1, 0.2], [3.0, 0.1, 3.0, 0.3]])
    made = {"sleepers/x": (x, "m"), "history/time": (time, "s"),
            "history/stage": (np.repeat([3, 4], [len(settle), len(passage)]), "-")}
    made |= {f"history/sleeper/{name}": one for name, one in histories(time, x).items()}
    made |= {f"history/energy/{name}": (scale * (1 + np.sin(time)), "J") for name, scale in
             (("kinetic", 1e-3), ("potential", 100.0), ("elastic", 2.0))}
    made |= {f"history/energy/{name}": (scale * time, "J") for name, scale in
             (("friction", 5.0), ("contact_damping", 2.0), ("local_damping", 1.0),
              ("breakage", 0.5), ("supplied", 9.0))}
    made |= {f"history/region/slab/{name}": (np.concatenate(
        [np.atleast_2d(value) * np.ones((len(time), 1)) for value in one], axis=1), "-")
             for name, one in REGION.items()}
    made |= {f"history/sensor/stone/{name}": (factor * time[:, None] * np.array([[1, 0, -2]]), unit)
             for name, factor, unit in SENSOR}
    made |= {"envelope/sleeper/displacement_min": (-1e-3 * np.ones(len(x)), "m"),
             "envelope/sleeper/displacement_max": (1e-3 * np.ones(len(x)), "m"),
             "envelope/sleeper/acceleration_max": (53.0 * np.ones(len(x)), "m/s^2")}
    if ground:
        made |= {"ground/x": (nodes, "m"),
                 "envelope/ground/displacement_min": (ground_displacement(nodes, wedge), "m"),
                 "envelope/ground/sigma_z_min": (ground_stress(nodes, wedge), "Pa")}
    made |= {"chains/load/segments": (chains, "m"),
             "chains/load/force": (np.array([100.0, 900.0]), "N"),
             "stones/load/centre": (chains[:, :2], "m"),
             "stones/load/radius": (np.array([0.03, 0.02]), "m"),
             "stones/load/sieved": (SIEVED, "m, kg"), "surface/load/top": (SURFACE, "m"),
             "breaks/load": (BREAKS, "s, -, -, m, m, m, m, kg, N, J, J"),
             "bonds/load/whole": (WHOLE, "-, -, -, m, m, m, N, -, -"),
             "bonds/load/broken": (BROKEN, "s, -, -, -, -, m, m, m, Pa, Pa, J"),
             "bed/grading": (GRADING, "m, %")}
    store(folder / "results.h5", made, version="0.0.0", ranks=2, deck=DECK.format(
        speed=SPEED, axles=list(AXLES), edge=EDGE, wedge=str(wedge).lower()))
    return folder
