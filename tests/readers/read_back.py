"""Reads DIRECTORY/bar.pvd and last.vtu with vtk and meshio; leaves each array's bytes in a file of its name."""
import pathlib
import sys
import xml.etree.ElementTree

import meshio
import numpy
import vtk
from vtk.util.numpy_support import vtk_to_numpy

place = pathlib.Path(sys.argv[1])


def leave(where, name, values):
    where.mkdir(exist_ok=True)
    numpy.asarray(values, dtype="<f8").tofile(where / name)


def with_vtk(path, where):
    reader = vtk.vtkXMLUnstructuredGridReader()
    reader.SetFileName(str(path))
    reader.Update()
    grid = reader.GetOutput()
    count = grid.GetNumberOfPoints()
    assert count > 0 and grid.GetNumberOfCells() == count
    for cell in range(count):
        assert grid.GetCellType(cell) == vtk.VTK_VERTEX
        assert grid.GetCell(cell).GetPointId(0) == cell
    leave(where, "points", vtk_to_numpy(grid.GetPoints().GetData()))
    data = grid.GetPointData()
    for number in range(data.GetNumberOfArrays()):
        values = vtk_to_numpy(data.GetArray(number))
        assert values.dtype == numpy.float64
        leave(where, data.GetArrayName(number), values)


def with_meshio(path, where):
    mesh = meshio.read(path)
    leave(where, "points", mesh.points)
    for name, values in mesh.point_data.items():
        leave(where, name, values)


listed = xml.etree.ElementTree.parse(place / "bar.pvd").getroot().iter("DataSet")
for number, item in enumerate(listed):
    for reader, read in [("vtk", with_vtk), ("meshio", with_meshio)]:
        where = place / f"{reader}_{number}"
        read(place / item.get("file"), where)
        leave(where, "time", [float(item.get("timestep"))])
with_vtk(place / "last.vtu", place / "vtk_last")
