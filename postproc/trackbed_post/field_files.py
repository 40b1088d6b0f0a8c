"""One array of a field file (VTKHDF) at points: nodes, centres of elements, or stones.

A stone has several cells in a file, its balls or faces, and is one point here: the mean of their
points, weighted by the square of `radius`. This point moves with the stone, but it is not exactly
the centre of mass, which the file does not have. Nodes that several ranks wrote are one point.
"""
import collections.abc
import dataclasses
import pathlib
import typing

import numpy as np

from trackbed_post import read

Arrays = dict[str, typing.Any]  # as of `arrays_of`
Files = list[tuple[float, pathlib.Path]]  # with their times, s
USUAL = ("displacement", "velocity", "force", "acceleration")  # the default is the first there is
BULK = (10, 12, 24)  # VTK's tetrahedra, hexahedra, quadratic tetrahedra
SOLID = ("solid", "body")  # array with the number of a solid of the ground, of a solid sleeper
SAME = 1e-9          # of the model's length: places that differ by less are one


@dataclasses.dataclass(frozen=True)
class Field:
    """`values` [point] or [point, component] at `place` [point, x y z], m. Stones have `number` and
    `pieces`, how many cells a stone has; elements have `corners`: [element, corner, x y z].
    Values at centres of elements have `solid`, the number of the solid of each point, and
    `solids`, those of the elements in `corners`."""
    part: str
    time: float  # s, nan if the series does not name the file
    unit: str
    place: np.ndarray
    values: np.ndarray
    number: np.ndarray
    pieces: np.ndarray
    corners: tuple[np.ndarray, ...] = ()
    solid: np.ndarray | None = None
    solids: tuple[np.ndarray, ...] = ()
    since: float = np.nan  # s, earlier instant, if the values are differences


@dataclasses.dataclass(frozen=True)
class Cells:
    """`nodes` of all cells, one after the other; `first` and `size` of each cell, and its kind."""
    points: np.ndarray
    nodes: np.ndarray
    first: np.ndarray
    size: np.ndarray
    kind: np.ndarray

    def mean(self, values: np.ndarray) -> np.ndarray:
        """Of each cell: mean of values at its nodes."""
        return np.add.reduceat(values[self.nodes], self.first) / self.size.reshape(
            -1, *[1] * (values.ndim - 1))

    def elements(self) -> tuple[np.ndarray, ...]:
        """Numbers of the elements, those with the same number of corners together."""
        bulk = np.flatnonzero(np.isin(self.kind, BULK))
        return tuple(bulk[self.size[bulk] == size] for size in np.unique(self.size[bulk]))

    def corners(self) -> tuple[np.ndarray, ...]:
        return tuple(self.points[self.nodes[self.first[which, None]
                                            + np.arange(self.size[which[0]])]]
                     for which in self.elements())


def cells_of(found: read.Quantities) -> Cells:
    """Each rank wrote a piece, whose cells number the points of the piece."""
    points, cells, ids = (found[f"NumberOf{what}"].values
                          for what in ("Points", "Cells", "ConnectivityIds"))
    borders = np.cumsum(cells + 1)[:-1] - 1
    size = np.delete(np.diff(found["Offsets"].values), borders)
    nodes = found["Connectivity"].values + np.repeat(np.cumsum(points) - points, ids)
    return Cells(found["Points"].values, nodes, np.cumsum(size) - size, size,
                  found["Types"].values)


def arrays_of(path: pathlib.Path | str) -> Arrays:
    """{name: read.Quantity} of a field file; with VTKHDF's own arrays below the key ""."""
    own = {name.removeprefix("VTKHDF/"): item for name, item in read.datasets(path).items()}
    if "Connectivity" not in own:
        raise read.Unreadable(f"{path} is not a field file of trackbed")
    arrays = {name.partition("/")[2]: item for name, item in own.items()
              if name.startswith(("PointData/", "CellData/"))}
    return {"": own, **arrays}


def _distinct(place: np.ndarray) -> np.ndarray:
    """Numbers of points, without those at the place of another one, in an order that does not
    depend on ranks."""
    step = SAME * max(np.ptp(place, axis=0).max(initial=0), 1e-6)
    return np.unique(np.round(place / step), axis=0, return_index=True)[1]


def _of_stones(cells: Cells, found: read.Quantities, values: np.ndarray
               ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """(number, cells, middle, value) of each stone."""
    number, one, which, pieces = np.unique(found["CellData/stone"].values, return_index=True,
                                           return_inverse=True, return_counts=True)
    weight = found["PointData/radius"].values**2 if "PointData/radius" in found else \
        np.ones(len(cells.points))
    of = np.repeat(which, cells.size)
    weight = weight.ravel()[cells.nodes]
    middle = np.stack([np.bincount(of, weight * cells.points[cells.nodes, axis]) for axis in
                       range(3)], 1) / np.bincount(of, weight)[:, None]
    return number, pieces, middle, values[one]


def field_of(path: pathlib.Path | str, time: float, arrays: Arrays, name: str) -> Field:
    """The Field of an array; "" for the positions of the points as values."""
    found, part = arrays[""], pathlib.Path(path).stem.rpartition("_")[2]
    cells = cells_of(found)
    if not len(cells.size):
        raise read.Unreadable(f"{path} holds no cell")
    corners, none = cells.corners(), np.empty(0)
    if name and f"PointData/{name}" in found:
        kept = _distinct(cells.points)
        return Field(part, time, arrays[name].unit, cells.points[kept], arrays[name].values[kept],
                     none, none, corners)
    centre = cells.mean(cells.points)
    values, unit = (arrays[name].values, arrays[name].unit) if name else (centre, "m")
    if corners and name:
        kept = _distinct(centre)
        solid = next((arrays[one].values.ravel() for one in SOLID if one in arrays),
                     np.zeros(len(centre)))
        return Field(part, time, unit, centre[kept], values[kept], none, none, corners,
                     solid[kept], tuple(solid[which] for which in cells.elements()))
    if "CellData/stone" not in found:
        return Field(part, time, unit, centre, values, none, none, corners)
    number, pieces, middle, values = _of_stones(cells, found, values)
    return Field(part, time, unit, middle, values if name else middle, number, pieces)


def change(now: Field, before: Field) -> Field:
    """The differences; of stones those that have the same cells at both instants."""
    if len(now.number):
        _, new, old = np.intersect1d(now.number, before.number, return_indices=True)
        same = now.pieces[new] == before.pieces[old]
        new, old = new[same], old[same]
        return dataclasses.replace(now, place=now.place[new], number=now.number[new],
                                   pieces=now.pieces[new], since=before.time,
                                   values=now.values[new] - before.values[old])
    if now.place.shape != before.place.shape or not np.allclose(now.place, before.place):
        raise read.Unreadable(f"{now.part}: its points at {before.time:g} s and {now.time:g} s "
                              "differ: no change can be drawn")
    return dataclasses.replace(now, values=now.values - before.values, since=before.time)


def files_of(path: pathlib.Path | str, parts: collections.abc.Sequence[str]) -> dict[str, Files]:
    """The files of each part in a result folder, or one field file."""
    path = pathlib.Path(path)
    if path.suffix == ".hdf":
        part = path.stem.rpartition("_")[2]
        instants = {file.name: time for time, file in read.series(path.parent.parent, part)}
        time = instants.get(path.name)
        own = read.time_in(path) if time is None and path.is_file() else time
        return {part: [(np.nan if own is None else own, path)]}
    folder = read.folder_of(path)
    if not folder.is_dir():
        raise read.Unreadable(f"{folder} does not exist; give a result folder or a .hdf file")
    if not list(folder.glob("fields/*.hdf")):
        raise read.Unreadable(f"{folder} has no field files: run its deck with output.fields=true")
    found = {part: read.series(folder, part) for part in parts}
    if not any(found.values()):
        there = sorted(file.name.removesuffix(".hdf.series")
                       for file in folder.glob("fields/*.hdf.series"))
        raise read.Unreadable(f"{folder} has no fields of {', '.join(parts)}, but of "
                              f"{', '.join(there)}: choose with --part, or run its deck with "
                              "these names in output.fields_parts")
    return {part: files for part, files in found.items() if files}


def nearest(files: Files, time: float | None) -> tuple[float, pathlib.Path]:
    """The file nearest to a time; the last one without it."""
    if time is None:
        return files[-1]
    far = [abs(one[0] - time) for one in files]
    return files[far.index(min(far))]


def _refuse_unknown(name: str, opened: dict[str, tuple[typing.Any, Arrays]]) -> typing.NoReturn:
    known = sorted({one for _, arrays in opened.values() for one in arrays if one})
    why = "; displacement of stones needs --relative-to TIME" if name == "displacement" and \
        "stones" in opened else ""
    raise read.Unreadable(f"{', '.join(opened)}: there is no array {name}; the arrays are "
                          f"{', '.join(known)}{why}")


def fields_at(path: pathlib.Path | str, parts: collections.abc.Sequence[str],
              name: str | None = None, time: float | None = None,
              since: float | None = None) -> tuple[str, list[Field]]:
    """(name of the array, [Field of each part that has it]) at an instant; `since`: its change
    from this earlier instant, of stones also that of their positions as `displacement`."""
    chosen = {part: nearest(files, time) for part, files in files_of(path, parts).items()}
    opened = {part: (instant, arrays_of(instant[1])) for part, instant in chosen.items()}
    moved = "displacement" if since is not None else ""  # of stones
    has = {part: {*arrays, *({moved} if moved and "stone" in arrays else ())} - {""}
           for part, (_, arrays) in opened.items()}
    there = [one for part in has for one in sorted(has[part])]
    name = name or [*(one for one in USUAL if one in there), *there, ""][0]
    fields = []
    for part, ((when, file), arrays) in opened.items():
        if name not in has[part]:
            continue
        inner = "" if name == moved and "stone" in arrays else name
        field = field_of(file, when, arrays, inner)
        if since is not None:
            field = change(field, _earlier(file, part, since, when, inner))
        fields.append(field)
    if not fields:
        _refuse_unknown(name, opened)
    if len(units := {field.unit for field in fields}) > 1:
        raise read.Unreadable(f"{name} has several units ({', '.join(units)}): choose one --part")
    return name, fields


def _earlier(file: pathlib.Path, part: str, since: float, now: float, name: str) -> Field:
    files = read.series(file.parent.parent, part)
    if not files:
        raise read.Unreadable(f"{file}: --relative-to needs the series {part}.hdf.series beside "
                              "it, in the folder `fields` of a run")
    when, before = nearest(files, since)
    if not when < now:
        raise read.Unreadable(f"--relative-to {since:g}: the nearest instant, {when:g} s, is not "
                              f"before the one that is drawn, {now:g} s")
    arrays = arrays_of(before)
    if name not in arrays:
        raise read.Unreadable(f"{before} has no array {name}; choose a later --relative-to")
    return field_of(before, when, arrays, name)
