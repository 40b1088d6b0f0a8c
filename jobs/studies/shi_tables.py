"""Tables of the document of the study shi."""
from . import study
from .shi_decks import DECK, DESIGNS, TITLES
from .shi_runs import FIXED, ON_SPRINGS, SOIL_ON_SPRINGS
from .shi_targets import values
from .study import as_file, span, table

LOADING, TRAINS = (next(stage for stage in DECK["stage"] if stage["name"] == name)
                   for name in ("bed_in", "trains"))
FRICTION = DECK["contact"][0]["friction"]
NEAR_END = 14  # m, x from which the end of the ground acts on the surface
REFERENCE = "reference: fixed base, rollers at the sides, 1.3 m thick"
THIN = "ground 1 m thick, viscous sides"
NAMES = {  # in tables
    FIXED: REFERENCE,
    "ground 1 m thick instead of 1.3 m": "out-of-plane thickness of the ground 1 m instead of 1.3",
    THIN: "out-of-plane thickness of the ground 1 m, viscous sides",
    ON_SPRINGS: "out-of-plane thickness 1 m, viscous base on springs of 1e8 Pa/m, viscous sides",
    SOIL_ON_SPRINGS: "out-of-plane thickness 1 m, springs of 1e8 Pa/m below the soil but not below "
                     "the structure, viscous sides",
    "loads of a power of the distance": "seat loads X^((s/0.6 m)^2) of each axle, X = 0.5531",
    "without a bottom, 10 m long at the top": "triangle, 10 m long at the top, none at the bottom",
    "upside down, 13 m long at the bottom": "3 m long at the top, 13 m at the bottom",
    "surface layer alone, 13 m": "none, but a surface layer of 4000 MPa 13 m long",
}
QUANTITIES = ("ground, structure", "ground, 6 to 11 m", "ground, far",
              "ground, 90 % of the rise")


def of_all(n, design, quantity, form=None):
    """Mean, least and most of all packings."""
    return span(values(n, design, quantity), form)


def cell(n, run, quantity):
    return study.cell(n, run, quantity,
                      missing="lost support" if "acceleration" in quantity else "")


def ground_rows(n, names):
    """A row per title and name of a variant of the ground alone."""
    return [(title, *(cell(n, f"ground_{design}_{as_file(name)}", quantity)
                      for design in DESIGNS for quantity in QUANTITIES))
            for title, name in names]


def same(names):
    return [(NAMES.get(name, name), name) for name in names]


def ground_table(first, rows):
    return table([first, *(f"{TITLES[design]}: {what}" for design in DESIGNS for what in
                           ("structure, mm", "6 to 11 m, mm", "last 2 m, mm", "90 %, m"))], rows)


def stones_rows(n, variants):
    """Packing 1 as it is, and with changes."""
    return [(title, *(cell(n, f"stones_{design}_{as_file(name)}", quantity) for design in DESIGNS
                      for quantity in QUANTITIES))
            for title, name in (("reference, packing 1", "1"), *variants)]
