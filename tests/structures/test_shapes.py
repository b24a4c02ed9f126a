"""Shapes of a structure on its mesh: closed forms, files, figures."""

import sys

import matplotlib.pyplot as plt
import numpy as np
import pytest
from tests.helpers.beams import free_beam
from tests.helpers.command_line import run

import slipfold as sf
from slipfold import InputError, Mesh, Structure

COUNT, LENGTH, STIFF, HEAVY = 12, 1.5, 30.0, 2.0


def cantilever(direction="uz", **options):
    """A beam of cubic elements, clamped at node 0."""
    mass, stiffness = free_beam(COUNT, length=LENGTH, stiffness=STIFF, density=HEAVY)
    names = [f"{kind}{node}" for node in range(1, COUNT + 1) for kind in (direction, "ry")]
    return Structure(mass[2:, 2:], None, stiffness[2:, 2:], names=names, **options)


def line():
    points = [[LENGTH * node / COUNT, 0] for node in range(COUNT + 1)]
    cells = [("line", (node, node + 1)) for node in range(COUNT)]
    return Mesh(tuple(range(COUNT + 1)), points, cells)


REDUCED = {"reduction": sf.ModalReduction(4)}


@pytest.mark.parametrize("options", [{}, REDUCED], ids=["whole", "reduced"])
def test_modes_of_a_cantilever(options):
    shapes = cantilever(**options).shapes(line(), modes=3)
    x = np.linspace(0, LENGTH, COUNT + 1)
    for number, root in enumerate((1.8751040687, 4.6940911330, 7.8547574382)):
        k = root / LENGTH
        ratio = (np.cosh(root) + np.cos(root)) / (np.sinh(root) + np.sin(root))
        exact = np.cosh(k * x) - np.cos(k * x) - ratio * (np.sinh(k * x) - np.sin(k * x))
        found = shapes.displacements[number, :, 2]
        # Cubic elements are wrong by a power of the length of an element over that of a wave.
        np.testing.assert_allclose(
            found / found[-1], exact / exact[-1], atol=1e-5 * 6.0 ** (2 * number)
        )
        assert abs(found[-1]) == pytest.approx(1, abs=1e-15)
        frequency = k**2 * np.sqrt(STIFF / HEAVY) / (2 * np.pi)
        assert shapes.labels[number].startswith(f"mode {number + 1}, {frequency:.3g}"[:10])
    assert not shapes.displacements[..., :2].any()


def test_a_motion_at_some_times_and_its_amplitude():
    parts = {"forcing": sf.HarmonicForce("uz12", F=2.0), "length_scale": 0.1, "f": 0.3}
    whole = cantilever(**parts)
    model = cantilever(**parts, reduction=sf.CraigBampton(["uz12"], modes=5), watch={"u": "uz6"})
    assert not line().rows(whole.structure["names"])[0, 2] >= 0  # clamped
    model = model.replace(C=sf.ModalDamping(0.02))
    orbit = sf.periodic_orbit(model)
    _, states = orbit.sample(16)
    shapes = model.shapes(line(), states)
    (_, tip), (_, middle) = orbit.output("uz12", 16), orbit.output("u", 16)
    np.testing.assert_allclose(shapes.displacements[:, 12, 2], tip, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(shapes.displacements[:, 6, 2], middle, rtol=1e-9, atol=1e-12)
    assert not shapes.displacements[:, 0].any()
    assert shapes.amplitude.displacements[0, 12, 2] == pytest.approx(np.ptp(tip) / 2, rel=1e-9)
    assert len(shapes.amplitude.labels) == 1


def cube():
    corners = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], dtype=float)
    points = np.vstack([corners, corners + np.array([0, 0, 1]), corners + np.array([0, 0, 2])])
    cells = [("hexahedron", tuple(range(8))), ("hexahedron", tuple(range(4, 12)))]
    return Mesh(tuple("abcdefghijkl"), points, cells, {"ux": "x", "w": "z"})


def test_faces_between_elements_are_left_out():
    assert len(cube().faces()) == 10
    assert len(line().faces()) == COUNT


def test_a_saved_file(tmp_path):
    mesh = cube()
    model = Structure(np.eye(2), None, np.diag([1.0, 4.0]), names="ux_a w_l")
    path = model.shapes(mesh, modes=2).save(tmp_path / "cube.vtk")
    text = path.read_text().splitlines()
    start = text.index("POINT_DATA 12")
    assert text[start + 1] == "VECTORS 1_mode_1,_0.1592_Hz double"
    assert text[start + 2] == "1 0 0"
    assert text[start + 2 + 13 + 11].split() == ["0", "0", "1"]
    assert text[text.index("CELLS 2 18") + 1] == "8 0 1 2 3 4 5 6 7"
    with pytest.raises(InputError, match=r"ends in \.txt; shapes are saved as .vtk"):
        model.shapes(mesh, modes=2).save("cube.txt")
    meshio = pytest.importorskip("meshio")
    again = Mesh.read(path)
    np.testing.assert_array_equal(again.points, mesh.points)
    assert again.cells == mesh.cells
    assert set(meshio.read(path).point_data) == {"1_mode_1,_0.1592_Hz", "2_mode_2,_0.3183_Hz"}


def test_files_of_nodes_and_elements(tmp_path):
    nodes, elements = tmp_path / "nodes.csv", tmp_path / "elements.csv"
    nodes.write_text("Node, x, y\n17, 0, 0\npad, 1, 0.5\n3, 0, 2\n")
    elements.write_text("node1, node2, node3, type\n17, pad, ,\n17, pad, 3, triangle\n")
    mesh = Mesh.read(nodes, elements)
    assert mesh.nodes == ("17", "pad", "3")
    np.testing.assert_array_equal(mesh.points, [[0, 0, 0], [1, 0.5, 0], [0, 2, 0]])
    assert mesh.cells == (("line", (0, 1)), ("triangle", (0, 1, 2)))
    assert mesh.rows(["ux17", "uy_pad"]).tolist() == [[0, -1, -1], [-1, 1, -1], [-1, -1, -1]]
    elements.write_text("node1, node2\n17, 4\n")
    with pytest.raises(InputError, match=r"has the node '4' in line 2, which has no coordinates"):
        Mesh.read(nodes, elements)
    elements.write_text("node1\n17\n")
    with pytest.raises(InputError, match="has an element of 1 nodes in line 2; give 2, 3"):
        Mesh.read(nodes, elements)
    nodes.write_text("node, x, y\n17, a, 0\n")
    with pytest.raises(InputError, match="x = 'a' for the node 17; give a number in m"):
        Mesh.read(nodes)
    nodes.write_text("node, x, y\n17, 1\n")
    with pytest.raises(InputError, match="y = '' for the node 17; give a number in m"):
        Mesh.read(nodes)
    nodes.write_text("name, x, y\n")
    with pytest.raises(InputError, match="must hold node, x, y, of which node is missing"):
        Mesh.read(nodes)


def test_what_meshio_reads_needs_it(monkeypatch):
    monkeypatch.setitem(sys.modules, "meshio", None)
    with pytest.raises(InputError, match=r"install slipfold\[mesh\], or save nodes and elements"):
        Mesh.read("beam.msh")


def test_figures():
    flat = cantilever("uy").shapes(line(), modes=2)
    ax = flat.plot(shape=1, scale=2)
    assert ax.name == "rectilinear"
    assert ax.get_title().endswith("drawn times 2")
    tallest = max(path.vertices[:, 1].max() for path in ax.collections[1].get_paths())
    assert tallest == pytest.approx(2 * flat.displacements[1, :, 1].max())
    model = Structure(np.eye(2), None, np.diag([1.0, 4.0]), names="ux_a w_l")
    solid = model.shapes(cube(), modes=2).plot()
    assert solid.name == "3d"
    assert cantilever().shapes(line()).plot().get_ylabel() == "z (m)"
    assert len(solid.collections) == 2
    with pytest.raises(InputError, match="shape = 2; give a place from 0 to 1"):
        flat.plot(shape=2)
    plt.close("all")


MISTAKES = {
    "points": (lambda: Mesh(["a"], [0, 1], []), "1 nodes have coordinates of shape"),
    "not finite": (lambda: Mesh(["a"], [[0, np.nan]], []), "coordinates of node a are not finite"),
    "twice": (lambda: Mesh(["a", "a"], np.eye(2), []), "a node of the mesh is there twice"),
    "kind": (
        lambda: Mesh(["a"], [[0, 0]], [("lines", (0,))]),
        "did you mean line. give a kind, line",
    ),
    "places": (lambda: Mesh(["a"], [[0, 0]], [("line", (0, 1))]), "give 2 places from 0 to 0"),
    "axis": (
        lambda: Mesh(["a"], [[0, 0]], [], {"w": "u"}),
        "direction 'w' of the mesh is along 'u'; give",
    ),
    "no node": (
        lambda: Structure([[1]], None, [[1]], names="q").shapes(line()),
        "no degree of freedom is that of a node of the mesh along ux uy uz",
    ),
    "states": (lambda: cantilever().shapes(line(), [1.0]), r"have the shape \(1, 1\), and the"),
    "NaN": (lambda: cantilever().shapes(line(), [np.nan] * 4 * COUNT), "states are not finite"),
    "no mode": (lambda: cantilever().shapes(line(), modes=0), "modes = 0; give a whole number"),
    "a path": (lambda: cantilever().shapes("a.csv"), "mesh = 'a.csv'; give a Mesh"),
    "scale": (lambda: cantilever().shapes(line()).plot(scale=np.nan), "scale = nan; give a finite"),
    "folder": (lambda: cantilever().shapes(line()).save("none/a.vtk"), "none/a.vtk cannot be"),
}


@pytest.mark.parametrize(("make", "message"), MISTAKES.values(), ids=MISTAKES)
def test_mistakes(make, message):
    with pytest.raises(InputError, match=message):
        make()


def test_all_sectors_of_a_disk():
    # Blades on a hub in the plane of x and y; ux is radial, uy along the circumference.
    sectors, angle = 12, 2 * np.pi / 12
    points = np.array([[1, 0], [2, 0], [np.cos(angle), np.sin(angle)]])
    mesh = Mesh(("hub", "tip", "next"), points, [("line", (0, 1)), ("line", (0, 2))])
    names = ["ux_hub", "uy_hub", "ux_tip", "uy_tip", "ux_next", "uy_next"]
    stiffness = np.diag([9.0, 7, 2, 1, 0, 0])
    for a, b in ((0, 4), (1, 5), (0, 2), (1, 3)):
        stiffness[np.ix_([a, b], [a, b])] += 0.5 * np.array([[1, -1], [-1, 1]])
    disk = Structure(
        np.diag([1.0, 1, 1, 1, 0, 0]), 0.02 * np.diag([1.0, 1, 1, 1, 0, 0]), stiffness, names=names,
        cyclic=sf.CyclicSymmetry(sectors, 3, names[:2], names[4:]),
        forcing=sf.HarmonicForce("uy_tip", F=0.1), f=0.2,
    )  # fmt: skip
    states = sf.periodic_orbit(disk).sample(16)[1]
    one, every = disk.shapes(mesh, states), disk.shapes(mesh, states, axis="z")
    np.testing.assert_allclose(every.mesh.points[2], every.mesh.points[3], atol=1e-15)
    own, all_of = one.displacements, every.displacements.reshape(16, sectors, 3, 3)
    np.testing.assert_allclose(all_of[:, 0, :2], own[:, :2], atol=1e-15)
    for at in range(sectors):
        turn = np.array([[np.cos(at * angle), -np.sin(at * angle)],
                         [np.sin(at * angle), np.cos(at * angle)]])  # fmt: skip
        later = np.roll(own[:, :2, :2], 16 * 3 * at // sectors, axis=0)
        np.testing.assert_allclose(all_of[:, at, :2, :2], later @ turn.T, atol=1e-9)
        # The boundary of a sector is the hub of the next one.
        hub = all_of[:, (at + 1) % sectors, 0]
        np.testing.assert_allclose(all_of[:, at, 2], hub, atol=1e-15)
    with pytest.raises(InputError, match="axis = 'w' is none; give x, y or z"):
        disk.shapes(mesh, states, axis="w")
    with pytest.raises(InputError, match="axis = 'z' is that of sectors, and the structure has"):
        cantilever().shapes(line(), axis="z")


def test_shapes_by_the_command(tmp_path):
    model, nodes, rods, out = (tmp_path / name for name in ("a.toml", "n.csv", "e.csv", "a.vtk"))
    model.write_text(
        "[structure]\nM = { diagonal = [1, 1, 1] }\nK = [[2, -1, 0], [-1, 2, -1], [0, -1, 2]]\n"
        'names = "w1 w2 w3"\n'
    )
    nodes.write_text("node,x,y\n0,0,0\n1,1,0\n2,2,0\n3,3,0\n4,4,0\n")
    rods.write_text("node1,node2\n0,1\n1,2\n2,3\n3,4\n")
    given = "shapes", str(model), "--mesh", str(nodes), "--elements", str(rods)
    given = *given, "--directions", "w=y", "--modes", "2", "--out"
    done = run(*given, str(out))
    assert done.exit_code == 0
    assert "mode 1, 0.1218 Hz, mode 2, 0.2251 Hz" in done.stderr
    middle = sf.Structure.from_toml(model).shapes(Mesh.read(nodes, rods, {"w": "y"}), modes=2)
    assert "mode_2" in out.read_text().replace(" ", "_")
    assert abs(middle.displacements[0, 2, 1]) == 1
    assert run(*given, str(tmp_path / "a.png"), "--mode", "2").exit_code == 0
    for wrong, word in (
        ((*given, str(tmp_path / "a.txt")), "a.txt; give .vtk"),
        (("shapes", "duffing", "--mesh", str(nodes)), "duffing has no mesh; give a structure"),
        ((*given[:-3], "--modes", "0"), "modes"),
    ):
        refused = run(*wrong)
        assert refused.exit_code == 2
        assert word in refused.stderr
