"""Writes meshes with gmsh, meshio, vtk and numpy, and what their readers must find.

usage: write_meshes.py DIRECTORY SIZE [--few]

DIRECTORY/expected.json names the files; for each: dimension, volumes and centroids of its cells in the file's
order, and sets as lists of cells from 0. Volumes and centroids come from gmsh's integration points, or
from vtk's integration of linear cells. --few: the files that are kept in tests/data/meshes (SIZE 0.7).
"""
import json
import pathlib
import sys

import gmsh
import numpy

place = pathlib.Path(sys.argv[1])
size = float(sys.argv[2])
everything = "--few" not in sys.argv
few = {
    "tetrahedron_4.1_text.msh", "tetrahedron_2.2_binary.msh", "tetrahedron.inp", "hexahedron.inp",
    "triangle6_4.1_binary.msh", "triangle6_2.2_text.msh", "triangle6.inp", "quadrilateral_4.1_text.msh",
    "cloud.txt", "cloud.csv", "plane.dat", "solids_default.vtu", "solids_ascii.vtu", "planes_raw.vtu",
    "vertices_wide.vtu", "cloud_big_endian.vtu",
}
place.mkdir(parents=True, exist_ok=True)
expected = {}


def measures(dimension):
    """Numbers, nodes, volumes and centroids of the cells that gmsh saves, in its order."""
    numbers, nodes, volumes, centroids = [], [], [], []
    for _, entity in gmsh.model.getEntities(dimension):
        if len(gmsh.model.getPhysicalGroupsForEntity(dimension, entity)) == 0:
            continue
        types, tags, corners = gmsh.model.mesh.getElements(dimension, entity)
        for kind, own, own_nodes in zip(types, tags, corners):
            points, weights = gmsh.model.mesh.getIntegrationPoints(kind, "Gauss8")
            _, determinants, where = gmsh.model.mesh.getJacobians(kind, points, entity)
            determinants = determinants.reshape(len(own), len(weights)) * weights
            where = where.reshape(len(own), len(weights), 3)
            own_volumes = determinants.sum(axis=1)
            moment = (where * determinants[:, :, None]).sum(axis=1)
            numbers.extend(int(tag) for tag in own)
            nodes.extend(set(map(int, row)) for row in own_nodes.reshape(len(own), -1))
            volumes.extend(abs(own_volumes))
            centroids.extend(moment / own_volumes[:, None])
    return numbers, nodes, volumes, centroids


def sets_of(dimension, numbers, nodes):
    found = {}
    for of, tag in gmsh.model.getPhysicalGroups():
        name = gmsh.model.getPhysicalName(of, tag)
        name = name or f"physical_{['point', 'curve', 'surface', 'volume'][of]}_{tag}"
        if of == dimension:
            members = set()
            for entity in gmsh.model.getEntitiesForPhysicalGroup(of, tag):
                for tags in gmsh.model.mesh.getElements(of, entity)[1]:
                    members.update(map(int, tags))
            found[name] = [k for k, number in enumerate(numbers) if number in members]
        else:
            touched = set(map(int, gmsh.model.mesh.getNodesForPhysicalGroup(of, tag)[0]))
            found[name] = [k for k, own in enumerate(nodes) if own & touched]
    return found


def expect(name, dimension, volumes, centroids, sets, total=None, tolerance=1e-12):
    expected[name] = {
        "tolerance": tolerance,
        "dimension": dimension,
        "volumes": [float(volume) for volume in volumes],
        "centroids": [[float(x) for x in centroid][:dimension] for centroid in centroids],
        "sets": sets,
        "total": total,
    }


def brick(shape):
    """A brick with named ends, an unnamed side and a pin, in two materials."""
    occ = gmsh.model.occ
    if shape in ("hexahedron", "wedge"):
        base = occ.addRectangle(0, 0, 0, 1, 0.5)
        occ.extrude([(2, base)], 0.1, 0.05, 0.25, [2], recombine=True)
        other = None
    else:
        one = occ.addBox(0, 0, 0, 0.6, 0.5, 0.25)
        two = occ.addBox(0.6, 0, 0, 0.4, 0.5, 0.25)
        occ.fragment([(3, one)], [(3, two)])
        other = two
    occ.synchronize()
    volumes = [tag for _, tag in gmsh.model.getEntities(3)]
    gmsh.model.addPhysicalGroup(3, volumes, 7, name="body")
    if other:
        gmsh.model.addPhysicalGroup(3, volumes[1:], 8, name="stiff part")
    faces = [tag for _, tag in gmsh.model.getEntities(2)]
    gmsh.model.addPhysicalGroup(2, faces[:1], 3, name="left")
    gmsh.model.addPhysicalGroup(2, faces[1:2], 4)
    gmsh.model.addPhysicalGroup(0, [1], 5, name="pin")
    return 0.125


def plate(shape):
    """A plate with a round hole at z = 2, and a disk beside it."""
    occ = gmsh.model.occ
    hole = occ.addDisk(0.5, 0.25, 2, 0.1, 0.1)
    sheet = occ.addRectangle(0, 0, 2, 1, 0.5)
    plates, _ = occ.cut([(2, sheet)], [(2, hole)])
    disk = occ.addDisk(2, 0, 2, 0.3, 0.2)
    occ.synchronize()
    gmsh.model.addPhysicalGroup(2, [tag for _, tag in plates], 7, name="plate")
    gmsh.model.addPhysicalGroup(2, [tag for _, tag in plates] + [disk], 8, name="both")
    gmsh.model.addPhysicalGroup(1, [tag for _, tag in gmsh.model.getEntities(1)][:1], 3, name="side")
    return None


def mesh(name, make, dimension, order=1, recombine=False, incomplete=False):
    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.model.add(name)
    total = make(name.rstrip("0123456789"))
    gmsh.option.setNumber("Mesh.MeshSizeMax", size)
    gmsh.option.setNumber("Mesh.ElementOrder", order)
    gmsh.option.setNumber("Mesh.RecombineAll", int(recombine))
    gmsh.option.setNumber("Mesh.SecondOrderIncomplete", int(incomplete))
    gmsh.option.setNumber("Mesh.SaveGroupsOfNodes", 1)
    gmsh.model.mesh.generate(dimension)
    numbers, nodes, volumes, centroids = measures(dimension)
    sets = sets_of(dimension, numbers, nodes)
    for version in (4.1, 2.2):
        for binary in (0, 1):
            gmsh.option.setNumber("Mesh.MshFileVersion", version)
            gmsh.option.setNumber("Mesh.Binary", binary)
            file = f"{name}_{version}_{'binary' if binary else 'text'}.msh"
            gmsh.write(str(place / file))
            expect(file, dimension, volumes, centroids, sets, total)
    gmsh.option.setNumber("Mesh.Binary", 0)
    # For hexahedra of 27 nodes Abaqus has another order than gmsh, which writes its own.
    if name == "hexahedron27":
        gmsh.finalize()
        return
    gmsh.write(str(place / f"{name}.inp"))
    # An input file has no blanks in names, numbers its unnamed groups, and names geometry too.
    renamed = {"physical_surface_4": "PhysicalSurface4"}
    sets = {renamed.get(key, key).replace(" ", "_"): value for key, value in sets.items()}
    expect(f"{name}.inp", dimension, volumes, centroids, sets, total)
    if everything:
        with_meshio(name, dimension, volumes, centroids, total)
    gmsh.finalize()


def with_meshio(name, dimension, volumes, centroids, total):
    import meshio

    read = meshio.read(place / f"{name}_4.1_text.msh")
    body = {"tetra", "tetra10", "hexahedron", "hexahedron20", "hexahedron27", "wedge", "pyramid"} if dimension == 3 else {
        "triangle", "triangle6", "quad", "quad8", "quad9"}
    cells = [block.data for block in read.cells if block.type in body]
    kinds = {block.type for block in read.cells if block.type in body}
    assert len(kinds) == 1, kinds
    cells = numpy.concatenate(cells)
    some = list(range(0, len(cells), 3))
    nodes = cells[0][:2]
    touching = [k for k, row in enumerate(cells) if set(row) & set(nodes)]
    whole = meshio.Mesh(read.points, [(kinds.pop(), cells)])
    named = meshio.Mesh(
        read.points, whole.cells, point_sets={"two": nodes}, cell_sets={"some": [numpy.array(some)]}
    )
    sets = {"two": touching, "some": some}
    for file, of, found, arguments in [
        (f"{name}_meshio.inp", named, sets, {}),
        (f"{name}_meshio_2.2.msh", whole, {}, {"file_format": "gmsh22", "binary": False}),
        (f"{name}_meshio_4.1.msh", whole, {}, {"file_format": "gmsh", "binary": True}),
        (f"{name}_meshio_4.1_text.msh", whole, {}, {"file_format": "gmsh", "binary": False}),
        (f"{name}_meshio.vtu", whole, {}, {}),
        (f"{name}_meshio_text.vtu", whole, {}, {"binary": False}),
        (f"{name}_meshio_plain.vtu", whole, {}, {"compression": None}),
    ]:
        # In .inp meshio lacks names for some, and calls quadrilaterals axisymmetric.
        no_name = ("biquadratic", "quadrilateral", "quadrilateral8", "hexahedron27")
        if file not in [f"{unnamed}_meshio.inp" for unnamed in no_name]:
            meshio.write(place / file, of, **arguments)
            # As text it writes 11 digits.
            tolerance = 1e-9 if file.endswith("_text.vtu") else 1e-12
            expect(file, dimension, volumes, centroids, found, total, tolerance)


def text():
    generator = numpy.random.default_rng(1)
    points, volumes = generator.uniform(-1, 1, (20, 3)), generator.uniform(0.1, 1, 20)
    blocks = generator.integers(1, 4, 20)
    sets = {f"block_{b}": [k for k in range(20) if blocks[k] == b] for b in sorted(set(map(int, blocks)))}
    rows = numpy.column_stack([points, blocks, volumes])
    form = ["%.17g"] * 3 + ["%d", "%.17g"]
    numpy.savetxt(place / "cloud.txt", rows, fmt=form, header="x y z block volume")
    expect("cloud.txt", 3, volumes, points, sets, float(volumes.sum()))
    numpy.savetxt(place / "cloud.csv", numpy.column_stack([points, volumes]), fmt="%.17g", delimiter=", ")
    expect("cloud.csv", 3, volumes, points, {}, float(volumes.sum()))
    numpy.savetxt(place / "plane.dat", numpy.column_stack([points[:, :2], volumes]), fmt="%.17e")
    expect("plane.dat", 2, volumes, points, {}, float(volumes.sum()))


def vtk_grids():
    import vtk
    from vtk.util.numpy_support import numpy_to_vtk

    def grid(cells, height):
        """Cells of unit size side by side, sheared; each a type and its points."""
        points, made = vtk.vtkPoints(), vtk.vtkUnstructuredGrid()
        points.SetDataTypeToDouble()
        for shift, (kind, corners) in enumerate(cells):
            ids = []
            for x, y, z in corners:
                # Voxels and pixels have sides along the axes.
                if kind not in (vtk.VTK_VOXEL, vtk.VTK_PIXEL):
                    x, y = x + 0.3 * y + 0.1 * z, y + 0.2 * z
                ids.append(points.InsertNextPoint(x + 1.5 * shift, y, z + height))
            made.InsertNextCell(kind, len(ids), ids)
        made.SetPoints(points)
        return made

    def middles(corners, edges):
        corners = [numpy.array(corner, float) for corner in corners]
        return corners + [sum(corners[k] for k in edge) / len(edge) for edge in edges]

    square = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
    lift = lambda base: base + [(x, y, 1) for x, y, _ in base]
    triangle = [square[0], square[1], square[3]]
    tetrahedron = triangle + [(0, 0, 1)]
    solids = [
        (vtk.VTK_TETRA, tetrahedron),
        (vtk.VTK_HEXAHEDRON, lift(square)),
        (vtk.VTK_VOXEL, [lift(square)[k] for k in (0, 1, 3, 2, 4, 5, 7, 6)]),
        (vtk.VTK_WEDGE, lift(triangle)),
        (vtk.VTK_PYRAMID, square + [(0.5, 0.5, 1)]),
        (vtk.VTK_QUADRATIC_TETRA, middles(tetrahedron, [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)])),
        (vtk.VTK_VERTEX, [(0, 0, 5)]),
        (vtk.VTK_LINE, [(0, 0, 5), (1, 0, 5)]),
        (vtk.VTK_TRIANGLE, triangle),
    ]
    sides = [(0, 1), (1, 2), (2, 3), (3, 0)]
    planes = [
        (vtk.VTK_TRIANGLE, triangle),
        (vtk.VTK_QUAD, square),
        (vtk.VTK_PIXEL, [square[k] for k in (0, 1, 3, 2)]),
        (vtk.VTK_QUADRATIC_TRIANGLE, middles(triangle, [(0, 1), (1, 2), (2, 0)])),
        (vtk.VTK_QUADRATIC_QUAD, middles(square, sides)),
        (vtk.VTK_BIQUADRATIC_QUAD, middles(square, sides + [(0, 1, 2, 3)])),
        (vtk.VTK_LINE, [(0, 0, 0), (1, 0, 0)]),
    ]

    def measured(made, count):
        volumes, centroids = [], []
        # Integrated as data, in double precision: positions come out in single.
        placed = vtk.vtkUnstructuredGrid()
        placed.ShallowCopy(made)
        where = vtk.vtkDoubleArray()
        where.DeepCopy(made.GetPoints().GetData())
        where.SetName("where")
        placed.GetPointData().AddArray(where)
        for cell in range(count):
            one = vtk.vtkExtractCells()
            one.SetInputData(placed)
            one.AddCellRange(cell, cell)
            total = vtk.vtkIntegrateAttributes()
            total.SetInputConnection(one.GetOutputPort())
            total.Update()
            found = total.GetOutput()
            data = found.GetCellData()
            volumes.append((data.GetArray("Volume") or data.GetArray("Area")).GetValue(0))
            moment = found.GetPointData().GetArray("where").GetTuple(0)
            centroids.append([x / volumes[-1] for x in moment])
        return volumes, centroids

    def write(made, name, tune):
        writer = vtk.vtkXMLUnstructuredGridWriter()
        writer.SetInputData(made)
        writer.SetFileName(str(place / name))
        tune(writer)
        assert writer.Write() == 1, name

    def forms(made, name):
        for form, tune in {
            "default": lambda it: None,
            "ascii": lambda it: it.SetDataModeToAscii(),
            "inline": lambda it: (it.SetDataModeToBinary(), it.SetCompressorTypeToNone()),
            "inline_zlib": lambda it: (it.SetDataModeToBinary(), it.SetBlockSize(2048)),
            "raw": lambda it: (it.SetEncodeAppendedData(False), it.SetCompressorTypeToNone()),
            "raw_zlib": lambda it: it.SetEncodeAppendedData(False),
            "base64": lambda it: it.SetCompressorTypeToNone(),
            "wide": lambda it: (it.SetHeaderTypeToUInt64(), it.SetBlockSize(2048)),
            "big_endian": lambda it: (it.SetByteOrderToBigEndian(), it.SetHeaderTypeToUInt64()),
        }.items():
            write(made, f"{name}_{form}.vtu", tune)
            yield f"{name}_{form}.vtu"

    for name, cells, dimension, height in [("solids", solids, 3, 0.0), ("planes", planes, 2, 3.0)]:
        made = grid(cells, height)
        if dimension == 2:
            flat = vtk.vtkPoints()
            flat.SetDataTypeToDouble()
            for k in range(made.GetNumberOfPoints()):
                x, y, _ = made.GetPoint(k)
                flat.InsertNextPoint(x, y, height)
            made.SetPoints(flat)
        blocks = numpy_to_vtk(numpy.arange(len(cells), dtype=numpy.int32) % 2, deep=True)
        blocks.SetName("Block")
        made.GetCellData().AddArray(blocks)
        volumes, centroids = measured(made, 6)
        sets = {"block_0": [0, 2, 4], "block_1": [1, 3, 5]}
        for file in forms(made, name):
            expect(file, dimension, volumes, centroids, sets, sum(volumes))

    # More points than a block of 2048 bytes holds, with vertices and without.
    generator, count = numpy.random.default_rng(2), 500 if everything else 120
    where, volumes = generator.uniform(-1, 1, (count, 3)), generator.uniform(0.1, 1, count)
    points = vtk.vtkPoints()
    points.SetData(numpy_to_vtk(where, deep=True))
    for name, vertices in [("cloud", False), ("vertices", True)]:
        made = vtk.vtkUnstructuredGrid()
        made.SetPoints(points)
        for k in range(count if vertices else 0):
            made.InsertNextCell(vtk.VTK_VERTEX, 1, [k])
        own = numpy_to_vtk(volumes, deep=True)
        own.SetName("Volume")
        made.GetPointData().AddArray(own)
        for file in forms(made, name):
            expect(file, 3, volumes, where, {}, float(volumes.sum()))


mesh("tetrahedron", brick, 3)
mesh("tetrahedron10", brick, 3, order=2)
mesh("wedge", brick, 3)
mesh("hexahedron", brick, 3, recombine=True)
mesh("hexahedron27", brick, 3, order=2, recombine=True)
mesh("hexahedron20", brick, 3, order=2, recombine=True, incomplete=True)
mesh("triangle", plate, 2)
mesh("triangle6", plate, 2, order=2)
mesh("quadrilateral", plate, 2, recombine=True)
mesh("quadrilateral8", plate, 2, order=2, recombine=True, incomplete=True)
mesh("biquadratic", plate, 2, order=2, recombine=True)
text()
vtk_grids()
if not everything:
    for file in set(expected) - few:
        (place / file).unlink()
        del expected[file]
lines = (f"{json.dumps(name)}: {json.dumps(found)}" for name, found in sorted(expected.items()))
(place / "expected.json").write_text("{\n" + ",\n".join(lines) + "\n}\n")
