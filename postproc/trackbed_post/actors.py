"""What VTK draws of a part of the model.

Coloured by an array, a vector by its magnitude, or plainly. In a picture with other parts, walls
and floor are edges, since they would hide the stones; rail and wheels, which are lines and disks in
field files, have a width that is drawn, not computed.
"""
from trackbed_post import grids

COLOURS = 256
MANY = 100_000  # balls, which are a few pixels large then and drawn with fewer faces
# Of parts that are not coloured by an array: none of them is a colour of the array.
PLAIN = {"stones": "#a6a6a6", "walls": "#808080", "sleepers": "#8c564b", "bodies": "#b9c4d0",
         "rail": "#303030", "wheels": "#d62728", "ground": "#e3d3b0", "solids": "#c49c94",
         "contacts": "#000000", "bonds": "#ff7f0e"}
OTHER = "#c7a7d1"
AT_REST = ("ground", "solids")     # parts whose files have points without their displacement
WALL, SLEEPER = 0, 2               # values of the array `part` of surfaces
RAIL_HIGH, RAIL_WIDE = 0.172, 0.072  # m, 60E1: height, width of the head
WHEEL_WIDE = 0.135                 # m


def colour_table(limits):
    """From dark to light: the order of the colours survives grey print and colour blindness."""
    import matplotlib
    import vtk
    table = vtk.vtkLookupTable()
    table.SetNumberOfTableValues(COLOURS)
    for k in range(COLOURS):
        table.SetTableValue(k, *matplotlib.colormaps["viridis"](k / (COLOURS - 1)))
    table.SetVectorModeToMagnitude()
    table.SetRange(limits)
    return table


def balls(grid, colouring):
    """Mapper of spheres at the balls of a grid; None if there are none."""
    from vtk.util.numpy_support import numpy_to_vtk, vtk_to_numpy
    import numpy as np
    import vtk
    if (found := grids.centres_of_balls(grid)) is None:
        return None
    (cells, nodes), places, radius = found
    points = vtk.vtkPoints()
    points.SetData(numpy_to_vtk(places, deep=True))
    centres = vtk.vtkPolyData()
    centres.SetPoints(points)
    data = {"size": radius}
    if colouring:
        values = vtk_to_numpy(colouring.array(grid))[nodes if colouring.on_points else cells]
        data["value"] = np.linalg.norm(values, axis=1) if values.ndim > 1 else values
    for name, values in data.items():
        item = numpy_to_vtk(np.ascontiguousarray(values, dtype=float), deep=True)
        item.SetName(name)
        centres.GetPointData().AddArray(item)
    ball = vtk.vtkSphereSource()
    ball.SetRadius(1)
    if len(places) > MANY:
        ball.SetThetaResolution(6)
        ball.SetPhiResolution(5)
    glyphs = vtk.vtkGlyph3DMapper()
    glyphs.SetInputData(centres)
    glyphs.SetSourceConnection(ball.GetOutputPort())
    glyphs.SetScaleArray("size")
    glyphs.SetScaleModeToScaleByMagnitude()
    glyphs.SetScalarModeToUsePointFieldData()
    glyphs.SelectColorArray("value")
    return glyphs


def shown(mappers, colouring, plain):
    """Actors of mappers."""
    import matplotlib
    import vtk
    actors = []
    for mapper in mappers:
        actors.append(vtk.vtkActor())
        actors[-1].SetMapper(mapper)
        if colouring:
            mapper.SetLookupTable(colour_table(colouring.limits))
            mapper.SetScalarRange(colouring.limits)
        else:
            mapper.ScalarVisibilityOff()
            actors[-1].GetProperty().SetColor(*matplotlib.colors.to_rgb(plain))
    return actors


def actors_of(name, grid, colouring=None, cuts=()):
    """Actors of a grid, coloured by an array or as PLAIN[name], between planes. Faces of stones and
    surfaces are shaded, elements and lines are not; plain elements are, or nothing would separate
    their sides."""
    import vtk
    mapper = vtk.vtkDataSetMapper()
    mapper.SetInputData(grid)
    if colouring:
        if colouring.on_points:
            mapper.SetScalarModeToUsePointFieldData()
        else:
            mapper.SetScalarModeToUseCellFieldData()
        mapper.SelectColorArray(colouring.name)
    spheres = balls(grid, colouring)
    actors = shown([one for one in (mapper, spheres) if one], colouring,
                   PLAIN.get(name, OTHER))
    actors[0].GetProperty().SetPointSize(4)
    for actor in actors:
        for plane in cuts:
            actor.GetMapper().AddClippingPlane(plane)
    kinds = vtk.vtkCellTypes()
    grid.GetCellTypes(kinds)
    faces = vtk.VTK_POLYGON, vtk.VTK_TRIANGLE
    lines = vtk.VTK_LINE, vtk.VTK_VERTEX, vtk.VTK_POLY_VERTEX
    alone = kinds.GetCellType(0) if kinds.GetNumberOfTypes() == 1 else faces[0]
    if alone in lines or (colouring and alone not in faces):
        actors[0].GetProperty().LightingOff()
    return actors


def cut(x, normal):
    """The plane at x that hides what is behind it."""
    import vtk
    plane = vtk.vtkPlane()
    plane.SetOrigin(x, 0, 0)
    plane.SetNormal(normal, 0, 0)
    return plane


def section(grid, cuts):
    """(grid, planes that are still to cut it): elements are cut here, so that they are not hollow;
    faces and balls by the graphics."""
    import vtk
    if not cuts or not grid.GetNumberOfCells() or grid.GetCell(0).GetCellDimension() < 3:
        return grid, cuts
    for plane in cuts:
        clip = vtk.vtkTableBasedClipDataSet()
        clip.SetInputData(grid)
        clip.SetClipFunction(plane)
        clip.Update()
        grid = clip.GetOutput()
    return grid, ()


def some_cells(grid, chosen):
    """The grid of those cells alone."""
    import vtk
    cells = vtk.vtkIdList()
    for k in chosen:
        cells.InsertNextId(int(k))
    extract = vtk.vtkExtractCells()
    extract.SetInputData(grid)
    extract.SetCellList(cells)
    extract.Update()
    return extract.GetOutput()


def edges(grid):
    """Lines at the angles between the faces of a surface, and at its borders."""
    import vtk
    faces, lines = vtk.vtkGeometryFilter(), vtk.vtkFeatureEdges()
    faces.SetInputData(grid)
    lines.SetInputConnection(faces.GetOutputPort())
    lines.ColoringOff()
    lines.Update()
    return lines.GetOutput()


def with_width(grid):
    """Rails as bars below their lines, and wheels as thick disks."""
    from vtk.util.numpy_support import vtk_to_numpy
    import numpy as np
    import vtk
    points, solid, source = vtk.vtkPoints(), vtk.vtkUnstructuredGrid(), []
    for k in range(grid.GetNumberOfCells()):
        ring, wide = vtk_to_numpy(grid.GetCell(k).GetPoints().GetData()), WHEEL_WIDE
        if len(ring) == 2:
            ring, wide = np.concatenate([ring, ring[::-1] - [0, 0, RAIL_HIGH]]), RAIL_WIDE
        near, far = ring - [0, wide / 2, 0], ring + [0, wide / 2, 0]
        around = [[near[i - 1], near[i], far[i], far[i - 1]] for i in range(len(ring))]
        for face in (near, far, *around):
            solid.InsertNextCell(vtk.VTK_POLYGON, len(face),
                                 [points.InsertNextPoint(*corner) for corner in face])
            source.append(k)
    solid.SetPoints(points)
    data = solid.GetCellData()
    data.CopyAllocate(grid.GetCellData())
    for k, cell in enumerate(source):
        data.CopyData(grid.GetCellData(), cell, k)
    return solid


def displaced(grid):
    """Elements where they are, as stones touch them: files have their points at rest."""
    import vtk
    if not grid.GetPointData().HasArray("displacement"):
        return grid
    warp = vtk.vtkWarpVector()
    warp.SetInputData(grid)
    warp.SetInputArrayToProcess(0, 0, 0, vtk.vtkDataObject.FIELD_ASSOCIATION_POINTS,
                                "displacement")
    warp.Update()
    return warp.GetOutput()


def pieces_of(part, grid, ends, parts=()):
    """(name in PLAIN, grid) of the things that a part consists of, in a picture with other parts,
    and rail and wheels only between the ends, along the track, of these: files have the rail of the
    whole track, which would go on over the colour bar. Solid sleepers are drawn as solids: the same
    faces twice would be striped."""
    from vtk.util.numpy_support import vtk_to_numpy
    import numpy as np
    if part in AT_REST:
        grid = displaced(grid)
    kinds = {"surfaces": "part", "train": "wheel"}.get(part)
    kind = grid.GetCellData().GetArray(kinds) if kinds else None
    if kind is None:
        return [(part, grid)]
    kind = vtk_to_numpy(kind)
    if part == "train":
        middle = np.array([np.mean(grid.GetCell(k).GetBounds()[:2]) for k in range(len(kind))])
        there = (middle >= ends[0]) & (middle <= ends[1])
        grouped = {"rail": (kind < 0) & there, "wheels": (kind >= 0) & there}
    else:
        grouped = {"walls": kind == WALL, "sleepers": kind == SLEEPER,
                   "bodies": (kind != WALL) & (kind != SLEEPER)}
    changed = {"walls": edges, "rail": with_width, "wheels": with_width}
    return [(name, changed.get(name, lambda same: same)(some_cells(grid, np.flatnonzero(mask))))
            for name, mask in grouped.items()
            if mask.any() and not (name == "sleepers" and "solids" in parts)]
