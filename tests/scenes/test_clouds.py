"""Point clouds in files: all of a whole file arrives, nothing of one that was cut off, and what is not used is said."""

import io
from pathlib import Path

import numpy as np
import pytest
import trimesh

from horosphere.errors import InputError
from horosphere.scenes import Scene
from horosphere.scenes._clouds import read_cloud
from horosphere.viewer import summarise

X = np.random.default_rng(5).uniform(-1, 1, (40, 3)).astype(np.float32).astype(np.float64)
TYPES = {"float": "f4", "double": "f8", "uchar": "u1", "int": "i4"}


def ply(form, columns, said=None, faces=()):
    """A PLY file written by hand: `columns` are (name, type, values)."""
    count = len(columns[0][2]) if said is None else said
    head = ["ply", f"format {form} 1.0", "comment by hand", f"element vertex {count}"]
    head += [f"property {kind} {name}" for name, kind, _ in columns]
    if len(faces):
        head += [f"element face {len(faces)}", "property list uchar int vertex_indices"]
    head = "\n".join([*head, "end_header\n"]).encode()
    if form == "ascii":
        rows = [" ".join(str(v) for v in row) for row in zip(*(c[2].tolist() for c in columns))]
        rows += [f"{len(face)} {' '.join(map(str, face))}" for face in faces]
        return head + "".join(row + "\n" for row in rows).encode()
    order = "<" if "little" in form else ">"
    table = np.zeros(len(columns[0][2]), [(name, order + TYPES[kind]) for name, kind, _ in columns])
    for name, _, values in columns:
        table[name] = values
    body = b"".join(bytes([len(face)]) + np.array(face, order + "i4").tobytes() for face in faces)
    return head + table.tobytes() + body


def pcd(form, columns, said=None, viewpoint="0 0 0 1 0 0 0", repeated=()):
    """A PCD file written by hand; columns in `repeated` have two numbers."""
    count = len(columns[0][2])
    codes = [TYPES[kind] for _, kind, _ in columns]
    rows = [("FIELDS", [name for name, _, _ in columns]), ("SIZE", [code[1] for code in codes])]
    rows += [("TYPE", [code[0].upper() for code in codes]), ("COUNT", ["12"[n in repeated] for n, _, _ in columns])]
    rows += [("WIDTH", [f"{count if said is None else said}"]), ("HEIGHT", ["1"]), ("VIEWPOINT", [viewpoint])]
    rows += [("POINTS", [f"{count if said is None else said}"]), ("DATA", [form])]
    head = "# .PCD v0.7\nVERSION 0.7\n" + "".join(f"{word} {' '.join(values)}\n" for word, values in rows)
    wide = [np.repeat(v[:, None], 1 + (n in repeated), axis=1).astype(f"<{c}") for (n, _, v), c in zip(columns, codes)]
    if form == "ascii":
        lines = [" ".join(str(v) for part in wide for v in part[k].tolist()) + "\n" for k in range(count)]
        return (head + "".join(lines)).encode()
    return head.encode() + b"".join(part[k].tobytes() for k in range(count) for part in wide)


FORMS = ("ascii", "binary_little_endian", "binary_big_endian")
XYZ = [(name, "float", X[:, k]) for k, name in enumerate("xyz")]
MIXED = [("red", "uchar", np.arange(40)), *[(n, "double", v) for n, _, v in XYZ[::-1]], ("ring", "int", np.arange(40))]


def saved(write, *arguments, **named):
    buffer = io.BytesIO()
    write(buffer, *arguments, **named)
    return buffer.getvalue()


RECORDS = np.zeros(40, [("t", "f8"), ("z", "f4"), ("y", "f4"), ("x", "f4")])
for k, letter in enumerate("xyz"):
    RECORDS[letter] = X[:, k]
WHOLE = {
    **{f"{form}.ply": ply(form, XYZ) for form in FORMS},
    **{f"more_{form}.ply": ply(form, MIXED) for form in FORMS},
    **{f"faces_{form}.ply": ply(form, MIXED, faces=[(0, 1, 2), (3, 4, 5, 6)]) for form in FORMS},
    "a.npy": saved(np.save, X),
    "f.npy": saved(np.save, np.asfortranarray(X)),
    "records.npy": saved(np.save, RECORDS),
    "four.npy": saved(np.save, np.c_[X, np.ones(40)]),
    "one.npz": saved(np.savez, cloud=X),
    "named.npz": saved(np.savez, points=X, colours=np.ones(7)),
    "bare.xyz": saved(np.savetxt, X),
    "counted.xyz": b"40\n" + saved(np.savetxt, X),
    "comma.csv": saved(np.savetxt, X, delimiter=", "),
    "trailing.csv": saved(np.savetxt, X, delimiter=",", newline=",\n"),
    "semicolon.csv": b"X;Y;Z\r\n" + saved(np.savetxt, X, delimiter=";", newline="\r\n"),
    "timed.csv": b'"time","x","y","z"\n' + saved(np.savetxt, np.c_[np.arange(40.0), X], delimiter=","),
    "commented.csv": saved(np.savetxt, np.c_[np.arange(40.0), X], header="t x y z"),
    **{f"{form}.pcd": pcd(form, XYZ) for form in ("ascii", "binary")},
    **{f"more_{form}.pcd": pcd(form, MIXED, repeated=("ring",)) for form in ("ascii", "binary")},
    # written by pypcd4 1.5.1 from X and an intensity
    "compressed.pcd": (Path(__file__).parent / "compressed.pcd").read_bytes(),
    "cloudcompare.xyz": b"//X Y Z\n" + saved(np.savetxt, X),
}


@pytest.mark.parametrize("name", WHOLE)
def test_whole_files(name, tmp_path):
    (tmp_path / name).write_bytes(WHOLE[name])
    points, notes = read_cloud(tmp_path / name)
    np.testing.assert_array_equal(points, X)
    said = {"four.npy": "the other is not used", "faces": "not its 2 faces; type: mesh"}
    wanted = next((text for key, text in said.items() if name.startswith(key)), None)
    assert (wanted is None and not notes) or (len(notes) == 1 and wanted in notes[0] and name in notes[0])


@pytest.mark.parametrize(
    "name", [name for name in WHOLE if name.endswith((".ply", ".pcd", ".npy", ".npz")) or "counted" in name]
)
def test_a_file_that_was_cut_off_is_refused(name, tmp_path):
    """At whatever byte; only within the last number of a text can nobody tell."""
    data = WHOLE[name]
    is_text = name.endswith(".xyz") or "ascii" in name
    last = len(data.rstrip()) - len(data.split()[-1]) if is_text else len(data) - 1
    seed = sum(name.encode())
    print("seed", seed)
    for cut in {last, *np.random.default_rng(seed).integers(1, last + 1, 40).tolist()}:
        (tmp_path / name).write_bytes(data[:cut])
        with pytest.raises(InputError):
            read_cloud(tmp_path / name)


@pytest.mark.parametrize("form", FORMS)
def test_a_ply_file_that_ends_cleanly_too_early_or_too_late(form, tmp_path):
    file = tmp_path / "cloud.ply"
    file.write_bytes(ply(form, XYZ, said=200))
    with pytest.raises(InputError, match=r"'cloud.ply': its header says 200 vertices, it holds 40 \(.*export it again"):
        read_cloud(file)
    file.write_bytes(ply(form, XYZ, said=10))
    with pytest.raises(InputError, match=r"it holds (30 lines|360 bytes) more than its header says"):
        read_cloud(file)
    file.write_bytes(ply(form, XYZ, said=0)[: ply(form, XYZ, said=0).index(b"end_header") + 11])
    with pytest.raises(InputError, match="holds no points"):
        read_cloud(file)


def test_what_is_wrong_in_a_pcd_file(tmp_path):
    file, whole = tmp_path / "cloud.pcd", pcd("ascii", XYZ)
    packed = bytearray(WHOLE["compressed.pcd"])
    packed[-60:] = b"\xff" * 60  # copies from before the beginning
    for data, words in (
        (pcd("binary", XYZ, said=50), "its header says 50 points, it holds 40"),
        (pcd("ascii", XYZ, said=39), "its header says 39 points, 40 follow"),
        (whole.rsplit(b" ", 1)[0], "point 39 of 40 has 2 of 3 numbers"),
        (whole.replace(b"FIELDS x", b"FIELDS a"), "expected fields x, y, z of one number each, got a, y, z"),
        (whole.replace(b"SIZE 4", b"SIZE 3"), "field 'x' of type 'F' with 3 bytes"),
        (whole.replace(b"HEIGHT 1", b"HEIGHT 2"), "WIDTH times HEIGHT are 80, POINTS 40"),
        (whole.replace(b"DATA ascii", b"DATA zip"), "PCD data 'zip'.*binary_compressed"),
        (whole.replace(b"TYPE F F F\n", b""), "header is not complete"),
        (b"ply\n", "no line DATA"),
        (pcd("ascii", [(n, "float", v[:0]) for n, _, v in XYZ]), "holds no points"),
        (bytes(packed), "cannot be unpacked|unpack to"),
    ):
        file.write_bytes(data)
        with pytest.raises(InputError, match=words):
            read_cloud(file)
    file.write_bytes(pcd("binary", XYZ, viewpoint="0 0 1.5 1 0 0 0"))
    points, notes = read_cloud(file)
    np.testing.assert_array_equal(points, X)
    assert "VIEWPOINT 0 0 1.5 1 0 0 0 is not used" in notes[0]


def test_half_a_line(tmp_path):
    (tmp_path / "a.ply").write_bytes(WHOLE["ascii.ply"].rsplit(b" ", 1)[0])
    with pytest.raises(InputError, match="vertex 39 of 40 has 2 of 3 numbers"):
        read_cloud(tmp_path / "a.ply")


ARRAYS = {
    "transposed": (X.T, r"shape \(3, 40\) .*transpose it"),
    "homogeneous": (np.ones((4, 40)), r"shape \(4, 40\) .*transpose it"),
    "two of three": (X.T[:, :2], "transpose it"),
    "image": (np.ones((48, 64, 3)), r"reshape\(-1, 3\)"),
    "flat": (X.ravel(), r"reshape\(-1, 3\)"),
    "depth": (np.ones((640, 480), np.uint16), r"\(640, 480\)"),
    "plane": (X[:, :2], "a point has x, y and z"),
    "complex": (X + 1j, "real numbers, got dtype complex128"),
    "words": (np.array([["a", "b", "c"]]), "real numbers, got dtype <U1"),
    "fields": (RECORDS[["t", "x"]], "fields x, y, z, got t, x"),
    "empty": (np.zeros((0, 3)), "holds no points"),
    "nan": (np.where(np.arange(40)[:, None] % 8 == 1, np.nan, X), "point 1 is not finite .5 of 40"),
}


@pytest.mark.parametrize("name", ARRAYS)
def test_arrays_that_are_no_cloud(name, tmp_path):
    array, words = ARRAYS[name]
    np.save(tmp_path / "cloud.npy", array)
    with pytest.raises(InputError, match=words) as caught:
        read_cloud(tmp_path / "cloud.npy")
    assert str(caught.value).startswith("'cloud.npy'") and "sequence" not in str(caught.value)
    np.savez(tmp_path / "two.npz", a=X, b=X)
    with pytest.raises(InputError, match="an array 'points', or one only, got a, b"):
        read_cloud(tmp_path / "two.npz")


TEXTS = {
    "decimal commas": ("0,1 0,2 0,3\n", "line 1: .*decimal points"),
    "decimal commas, semicolons": ("x;y;z\n0,1;0,2;0,3\n", "line 2: expected a number, got '0,1' .*decimal points"),
    "cut": ("1 2 3\n\n4 5 6\n7 8", "line 4: 2 numbers, 3 in the lines before"),
    "count": ("5\n1 2 3\n4 5 6\n", "its first line says 5 points, 2 follow"),
    "other names": (
        "time,east,north,up\n1,2,3,4\n",
        "4 columns under the header.*name three of the columns x, y and z",
    ),
    "plane": ("1 2\n3 4\n", "got 2 numbers"),
    "word": ("1 2 3\n4 five 6\n", "line 2: expected a number, got 'five'"),
}


@pytest.mark.parametrize("name", TEXTS)
def test_texts_that_are_no_cloud(name, tmp_path):
    text, words = TEXTS[name]
    (tmp_path / "cloud.csv").write_text(text)
    with pytest.raises(InputError, match=words):
        read_cloud(tmp_path / "cloud.csv")


def test_what_is_not_sure_in_a_text_is_said(tmp_path):
    (tmp_path / "a.csv").write_text("east,north,up\n1,2,3\n4,5,6")
    points, notes = read_cloud(tmp_path / "a.csv")
    np.testing.assert_array_equal(points, [[1, 2, 3], [4, 5, 6]])
    assert "no line break" in notes[0] and "east, north, up are taken as x, y, z" in notes[1]
    (tmp_path / "a.csv").write_bytes(b"\xff\xfe1\x00")
    with pytest.raises(InputError, match="no text: byte 0 is not UTF-8"):
        read_cloud(tmp_path / "a.csv")


SCENE = """horosphere/scene: 1
robot: {type: point, radius: 0.05, dimension: 3}
start: {position: [0, 0, -3]}
goal: {position: [0, 0, 3]}
obstacles:
  - {type: points, file: cloud.npy, radius: 0.01}
"""


def test_the_notes_reach_the_user(tmp_path):
    np.save(tmp_path / "cloud.npy", np.c_[X, np.ones(40)])
    (tmp_path / "scene.yaml").write_text(SCENE)
    scene = Scene.load(tmp_path / "scene.yaml")
    assert scene.notes == ("cloud.npy: its first three columns are taken as x, y, z; the other is not used",)
    assert scene.notes[0] in summarise(scene, None).notes
    assert scene.with_(name="other").notes == scene.notes and scene.with_(obstacles=()).notes == ()


def test_a_cloud_is_placed_and_a_large_one_is_questioned(tmp_path):
    """The camera looks along x from one metre up, and counts in millimetres."""
    np.save(tmp_path / "cloud.npy", 1e3 * X)
    where = "rpy_deg: [0, 0, 90], position: [0, 0, 1]"
    (tmp_path / "scene.yaml").write_text(SCENE.replace("radius: 0.01", f"radius: 0.01, scale: 0.001, {where}"))
    scene = Scene.load(tmp_path / "scene.yaml")
    np.testing.assert_allclose(scene.obstacles[0].points, np.c_[-X[:, 1], X[:, 0], X[:, 2] + 1.0], atol=1e-12)
    assert scene.notes == ()
    scene.save(tmp_path / "again.yaml")
    again = Scene.load(tmp_path / "again.yaml").obstacles[0].points
    np.testing.assert_allclose(again, scene.obstacles[0].points, atol=1e-12)
    (tmp_path / "scene.yaml").write_text(SCENE.replace("[0, 0, -3]", "[0, 0, -3000]"))
    assert "cloud.npy: 1,9" in (note := Scene.load(tmp_path / "scene.yaml").notes[0])
    assert note.endswith("m long; are these millimetres? Then write scale: 0.001")


def mesh_bytes(kind, **how):
    data = trimesh.creation.icosphere(subdivisions=1).export(file_type=kind, **how)
    return data if isinstance(data, bytes) else data.encode()


QUADS = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
CORNERS = [(n, "float", np.array([k >> j & 1 for k in range(8)])) for j, n in enumerate("xyz")]
BIG = [("pad", "int", np.zeros(8)), *CORNERS]
MESHES = {
    "a.stl": mesh_bytes("stl"),
    "text.stl": mesh_bytes("stl_ascii"),
    "a.ply": mesh_bytes("ply"),
    "text.ply": mesh_bytes("ply", encoding="ascii"),
    "quads.ply": ply("ascii", CORNERS, faces=QUADS),
    "quads_little.ply": ply("binary_little_endian", CORNERS, faces=QUADS),
    "quads_big.ply": ply("binary_big_endian", BIG, faces=QUADS),
}


@pytest.mark.parametrize("name", MESHES)
def test_meshes_that_were_cut_off(name, tmp_path):
    from horosphere.robots._meshes import read_triangles
    from horosphere.scenes._files import read_mesh

    (tmp_path / name).write_bytes(MESHES[name])
    vertices, faces = read_mesh(tmp_path / name)
    triangles = read_triangles(name, (1.0, 1.0, 1.0), tmp_path / "robot.urdf")
    np.testing.assert_array_equal(vertices[faces], triangles)
    assert trimesh.Trimesh(vertices, faces).is_watertight and len(faces) in (12, 80)
    data = MESHES[name]
    last = (
        len(data.rstrip()) - len(data.split()[-1]) if b"ascii" in data[:30] or b"solid" in data[:9] else len(data) - 1
    )
    seed = sum(name.encode())
    print("seed", seed)
    for cut in {last, *np.random.default_rng(seed).integers(1, last, 25).tolist()}:
        (tmp_path / name).write_bytes(data[:cut])
        with pytest.raises(InputError, match=r"cannot be read|no triangles"):
            read_mesh(tmp_path / name)
        with pytest.raises(InputError, match=f"mesh {name}"):
            read_triangles(name, (1.0, 1.0, 1.0), tmp_path / "robot.urdf")


def test_off_and_obj(tmp_path):
    """OFF has counts; OBJ has none: a line cut short and a face on a vertex that is not there can be told."""
    from horosphere.robots._meshes import read_triangles

    texts = {
        "a.off": mesh_bytes("off"),
        "a.obj": b"v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nf 1//1 2//1 3//1\nf -1 -2 -3\n",
    }
    for name, data in texts.items():
        (tmp_path / name).write_bytes(data)
        assert len(read_triangles(name, (1.0, 1.0, 1.0), tmp_path / "robot.urdf")) == (80 if "off" in name else 2)
    lines = texts["a.off"].splitlines(keepends=True)
    for name, data, words in (
        ("a.off", b"".join(lines[:-1]), "its header says 80 faces, it holds 79"),
        ("a.off", b"".join(lines[:30]), "its header says 42 vertices, it holds"),
        ("a.off", b"".join(lines).rstrip().rsplit(b" ", 1)[0], "face 79 has too few numbers"),
        ("a.obj", texts["a.obj"].rsplit(b" ", 1)[0], "line 6: a face of 2 vertices"),
        ("a.obj", b"v 0 0 0\nv 1 0\n", "line 2: a vertex of 2 numbers"),
        ("a.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n", "line 4: a face on vertex '4' of 3"),
    ):
        (tmp_path / name).write_bytes(data)
        with pytest.raises(InputError, match=words):
            read_triangles(name, (1.0, 1.0, 1.0), tmp_path / "robot.urdf")


def test_a_whole_mesh_with_faces_of_different_sizes(tmp_path):
    """Is told from one that was cut off; the library reads it in no binary form."""
    from horosphere.scenes._files import read_mesh

    data = ply("binary_big_endian", BIG, faces=[*QUADS[:5], (1, 5, 7), (1, 7, 3)])
    (tmp_path / "m.ply").write_bytes(data)
    with pytest.raises(InputError, match="triangulate it"):
        read_mesh(tmp_path / "m.ply")
    (tmp_path / "m.ply").write_bytes(data[:-13])
    with pytest.raises(InputError, match="its header says 7 faces, it holds 6"):
        read_mesh(tmp_path / "m.ply")
