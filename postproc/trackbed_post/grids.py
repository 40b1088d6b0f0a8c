"""Grids of field files as VTK reads them, what surrounds them, and by what they are coloured."""
import dataclasses

from trackbed_post import framing, read

# Part -> array by which it is coloured, unless another is given.
USUAL = {"stones": "velocity", "contacts": "force", "surfaces": "sleeper_displacement"}


def read_grid(path):
    import vtk
    reader = vtk.vtkHDFReader()
    if not reader.CanReadFile(str(path)):
        raise read.Unreadable(f"{path} is not a VTKHDF file")
    reader.SetFileName(str(path))
    reader.Update()
    return reader.GetOutput()


def read_grids(files):
    """Part -> grid of an instant; parts without a cell are left out."""
    grids = {part: read_grid(path) for part, path in files.items()}
    return {part: grid for part, grid in grids.items() if grid.GetNumberOfCells()}


@dataclasses.dataclass(frozen=True)
class Colouring:
    """By what a part is coloured: an array, the values at the ends of the colours, its unit, and
    which values are beyond them, in words."""
    part: str
    name: str
    on_points: bool
    limits: tuple
    unit: str
    beyond: str = ""

    def title(self):
        name = "speed" if self.name == "velocity" else self.name
        return f"{name}, {self.unit}" if self.unit else name

    def words(self):
        words = f"{self.name} from {self.limits[0]:.4g} to {self.limits[1]:.4g} {self.unit}".strip()
        return ", ".join(filter(None, (words, self.beyond)))

    def array(self, grid):
        """Of a grid, or None: other instants may lack it."""
        return (grid.GetPointData() if self.on_points else grid.GetCellData()).GetArray(self.name)


def unit_of(path, name, on_points):
    """Unit of a dataset of a field file, which VTK does not read."""
    found = read.datasets(path).get(f"VTKHDF/{'Point' if on_points else 'Cell'}Data/{name}")
    return found.unit if found is not None and found.unit != "1" else ""


class Survey:
    """The box around the grids of all instants of a picture or film, and the ranges of the arrays
    of the part that is coloured: so that all have the same camera and colours."""

    def __init__(self, part):
        self.part, self.ranges, self.file = part, {}, None
        self.speed = 0.0  # m/s, of all but the fastest stones of an instant, the largest of all
        self.boxes = {}  # part -> (lowest, highest) corner

    def add(self, files):
        """The grids of an instant, which are returned."""
        grids = read_grids(files)
        for part, grid in grids.items():
            self.boxes[part] = hull([self.boxes[part]] if part in self.boxes else [], grid)
        if self.part in grids:
            self.file = self.file or files[self.part]
            self._add_ranges(grids[self.part])
        return grids

    def _add_ranges(self, grid):
        self.speed = max(self.speed, speed_of(grid))
        for data, on_points in ((grid.GetPointData(), True), (grid.GetCellData(), False)):
            for k in range(data.GetNumberOfArrays()):
                array = data.GetArray(k)
                low, high = array.GetRange(-1 if array.GetNumberOfComponents() > 1 else 0)
                key = (array.GetName(), on_points)
                known = self.ranges.get(key, (low, high))
                self.ranges[key] = (min(low, known[0]), max(high, known[1]))

    def colouring(self, name=None, limits=None):
        """By the array of this name; else by that of USUAL if it varies; else by the first array
        that varies, or any."""
        chosen = list(self.ranges)
        names = ", ".join(sorted({one for one, _ in chosen}))
        if not chosen:
            raise read.Unreadable("the file has no array")
        if name is not None:
            chosen = [key for key in chosen if key[0] == name]
        if not chosen:
            raise read.Unreadable(f"the file has no array {name}; its arrays: {names}")
        varying = [key for key in chosen if self.ranges[key][0] < self.ranges[key][1]]
        usual = [key for key in varying if key[0] == USUAL.get(self.part)]
        key = (usual or varying or chosen)[0]
        low, high = self.ranges[key]
        beyond = ""
        if not limits and (self.part, key) == ("stones", ("velocity", False)) \
                and low < self.speed < high:
            beyond = f"the fastest {100 - framing.MOST} % of the stones are beyond the colours, " \
                f"up to {high:.3g} m/s"
            low, high = 0.0, self.speed
        return Colouring(self.part, *key, tuple(limits or (low, high)), unit_of(self.file, *key),
                         beyond)

    def box(self):
        """(lowest, highest) corner around all parts; along and across the track without wheels,
        which are also beyond the bed."""
        import numpy as np
        bed = [box for part, box in self.boxes.items() if part != "train"]
        low, high = joined(bed or list(self.boxes.values()))
        if "train" in self.boxes:
            lowest, highest = self.boxes["train"]
            low = np.append(low[:2], min(low[2], lowest[2]))
            high = np.append(high[:2], max(high[2], highest[2]))
        return low, high


def speed_of(grid):
    """Speed of all but the fastest stones of a grid, m/s; 0 for other parts."""
    from vtk.util.numpy_support import vtk_to_numpy
    arrays = [grid.GetCellData().GetArray(name) for name in ("velocity", "stone")]
    return framing.highest_speed(*map(vtk_to_numpy, arrays)) if all(arrays) else 0.0


def joined(boxes):
    import numpy as np
    return (np.min([low for low, _ in boxes], axis=0), np.max([high for _, high in boxes], axis=0))


def hull(boxes, grid):
    """The box around others and a grid, with its balls."""
    import numpy as np
    bounds = np.array(grid.GetBounds())
    found = [*boxes, (bounds[::2], bounds[1::2])]
    if (of_balls := centres_of_balls(grid)) is not None:
        _, centres, radius = of_balls
        found.append(((centres - radius[:, None]).min(axis=0), (centres + radius[:, None])
                      .max(axis=0)))
    return joined(found)


def centres_of_balls(grid):
    """((cells, nodes), centres, radii) of the balls: points with a radius of cells that consist of
    points; None if there are none."""
    from vtk.util.numpy_support import vtk_to_numpy
    import numpy as np
    import vtk
    radius = grid.GetPointData().GetArray("radius")
    if radius is None:
        return None
    of_points = np.isin(vtk_to_numpy(grid.GetCellTypesArray()), (vtk.VTK_VERTEX,
                                                                 vtk.VTK_POLY_VERTEX))
    if not of_points.any():
        return None
    lengths = np.diff(vtk_to_numpy(grid.GetCells().GetOffsetsArray()))
    cells = np.repeat(np.arange(len(lengths)), lengths)
    nodes = vtk_to_numpy(grid.GetCells().GetConnectivityArray())[of_points[cells]]
    cells = cells[of_points[cells]]
    return ((cells, nodes), vtk_to_numpy(grid.GetPoints().GetData())[nodes],
            vtk_to_numpy(radius).ravel()[nodes])
