"""Opens the files of fields_test on N ranks with VTK, as in ParaView: check_vtkhdf.py FOLDER N"""

import sys

import h5py
import vtk
from vtk.util.numpy_support import vtk_to_numpy

folder, ranks = sys.argv[1], int(sys.argv[2])


def read(kind):
    reader = vtk.vtkHDFReader()
    path = f"{folder}/fields_{kind}_{ranks}.hdf"
    if not reader.CanReadFile(path):
        sys.exit(f"{path} is not recognised as a VTKHDF file")
    # ParaView 5.11 does not read a file whose type is stored with a terminating zero.
    with h5py.File(path, "r") as file:
        stored = h5py.h5a.open(file["VTKHDF"].id, b"Type").get_type().get_size()
    expect(stored, len("UnstructuredGrid"), "bytes of the type")
    reader.SetFileName(path)
    reader.Update()
    return reader.GetOutput()


def expect(found, wanted, what):
    if found != wanted:
        sys.exit(f"{what}: {found}, expected {wanted}")


cubes = read("cubes")
cells = sum(range(ranks))
points = sum(4 * (r + 1) for r in range(1, ranks))
expect(cubes.GetNumberOfPoints(), points, "points")
expect(cubes.GetNumberOfCells(), cells, "cells")
if cells:
    expect({cubes.GetCellType(c) for c in range(cells)}, {vtk.VTK_HEXAHEDRON}, "cell types")
    # Each cell has volume 1 only if the point numbers of every piece are correct.
    quality = vtk.vtkCellSizeFilter()
    quality.SetInputData(cubes)
    quality.Update()
    volumes = vtk_to_numpy(quality.GetOutput().GetCellData().GetArray("Volume"))
    expect([round(float(v), 12) for v in volumes], [1.0] * cells, "volumes")
    data = cubes.GetPointData()
    names = sorted(data.GetArrayName(i) for i in range(data.GetNumberOfArrays()))
    expect(names, ["height", "velocity"], "point arrays")
    z = vtk_to_numpy(cubes.GetPoints().GetData())[:, 2]
    expect(vtk_to_numpy(data.GetArray("height")).tolist(), z.tolist(), "heights")
    expect(vtk_to_numpy(data.GetArray("velocity"))[:, 2].tolist(), z.tolist(), "speeds")
    stress = vtk_to_numpy(cubes.GetCellData().GetArray("stress"))
    expect(stress.tolist(), [[0, 1, 2, 3, 4, 5]] * cells, "stress")

particles = read("particles")
expect(particles.GetNumberOfPoints(), 6 * ranks, "particles")
expect([particles.GetCell(c).GetNumberOfPoints() for c in range(particles.GetNumberOfCells())],
       [1, 2, 3] * ranks, "points of particles")
expect(particles.GetCellType(0), vtk.VTK_POLY_VERTEX, "particle cell type")
kinds = read("kinds")
expect([kinds.GetCellType(c) for c in range(kinds.GetNumberOfCells())],
       [vtk.VTK_POLYGON] + [vtk.VTK_POLY_VERTEX, vtk.VTK_POLYGON] * (ranks - 1), "kinds of cells")
expect([kinds.GetCell(c).GetNumberOfPoints() for c in range(kinds.GetNumberOfCells())],
       [5] + [1, 4] * (ranks - 1), "points of these cells")
expect(read("nothing").GetNumberOfPoints(), 0, "points of nothing")
