"""OBJ, PLY, STL, OFF, COLLADA, FBX and URDF files made by code, whole and broken."""

import struct
from pathlib import Path

import numpy as np
import trimesh

from tests.meshes.test_conversion import FBX
from tests.soak.meshes.cases import makes
from tests.soak.meshes.shapes import GREEN, checker, colored_cup, cup, exported, grid, obj_text, textured_box

TRIANGLE = "v 0 0 0\nv 1 0 0\nv 0 1 0\n"


# OBJ
@makes("cup.obj")
def _(file: Path) -> None:
    file.write_text(obj_text(cup()))


@makes("cup_300m.obj", "convert it with --unit mm")
def _(file: Path) -> None:
    file.write_text(obj_text(cup(3000.0)))


@makes("cup_third_mm.obj", "a factor of 1000 is missing")
def _(file: Path) -> None:
    file.write_text(obj_text(cup(0.003)))


@makes("far_origin.obj", "away from its origin")
def _(file: Path) -> None:
    moved = cup()
    moved.apply_translation((40.0, -12.0, 3.0))
    file.write_text(obj_text(moved))


@makes("degenerate.obj", "without area")
def _(file: Path) -> None:
    file.write_text(obj_text(cup()) + "f 1 1 2\nf 3 3 3\n")


@makes("doubled.obj", "doubled triangles")
def _(file: Path) -> None:
    text = obj_text(cup())
    file.write_text(text + "\n".join(line for line in text.splitlines() if line.startswith("f")))


@makes("nan.obj", "missing or infinite corners")
def _(file: Path) -> None:
    lines = obj_text(cup()).splitlines()
    lines[10], lines[50] = "v nan 0 0", "v 0 inf 0"
    file.write_text("\n".join(lines))


@makes("overflow.obj", "missing or infinite corners")
def _(file: Path) -> None:
    lines = obj_text(cup()).splitlines()
    lines[10], lines[50] = "v 1e300 0 0", "v 0 -4e38 0"
    file.write_text("\n".join(lines))


@makes("non_manifold.obj")
def _(file: Path) -> None:
    file.write_text(TRIANGLE + "v 0 0 1\nv 0 -1 0\nf 1 2 3\nf 1 2 4\nf 1 2 5\n")


@makes("inside_out.obj", "right side out")
def _(file: Path) -> None:
    file.write_text(obj_text(cup(), order=(2, 1, 0)))


@makes("half_flipped.obj")
def _(file: Path) -> None:
    mesh = trimesh.creation.icosphere(subdivisions=3, radius=0.1)
    faces = np.array(mesh.faces)
    faces[::2] = faces[::2, ::-1]
    file.write_text(obj_text(trimesh.Trimesh(mesh.vertices, faces, process=False)))


@makes("huge_indices.obj", "out of bounds", refused=True)
def _(file: Path) -> None:
    file.write_text(obj_text(cup()) + "f 1 2 2000000000\nf 5 6 99999999999999999999\n")


@makes("negative_indices.obj")
def _(file: Path) -> None:
    file.write_text(TRIANGLE + "f -3 -2 -1\n")


@makes("polygons.obj")
def _(file: Path) -> None:
    star = [(np.cos(i * np.pi / 5) * (1 + i % 2), np.sin(i * np.pi / 5) * (1 + i % 2), 0) for i in range(10)]
    file.write_text("".join(f"v {x} {y} {z}\n" for x, y, z in star) + "f " + " ".join(map(str, range(1, 11))) + "\n")


@makes("truncated.obj")
def _(file: Path) -> None:
    text = obj_text(cup())
    file.write_text(text[: int(len(text) * 0.8)])


@makes("no_size.obj", "no triangle is left", refused=True)
def _(file: Path) -> None:
    file.write_text("v 1 1 1\n" * 3 + "f 1 2 3\n")


@makes("points.obj", "no triangles", refused=True)
def _(file: Path) -> None:
    file.write_text(TRIANGLE)


@makes("lines.obj", "no triangles", refused=True)
def _(file: Path) -> None:
    file.write_text(TRIANGLE + "l 1 2 3\n")


@makes("empty.obj", "empty file", refused=True)
def _(file: Path) -> None:
    file.write_bytes(b"")


@makes("pointer.obj", "Git LFS", refused=True)
def _(file: Path) -> None:
    file.write_text("version https://git-lfs.github.com/spec/v1\noid sha256:00\nsize 1\n")


@makes("missing_material.obj", "gone.mtl is missing")
def _(file: Path) -> None:
    file.write_text("mtllib gone.mtl\nusemtl a\n" + obj_text(cup()))


@makes("missing_picture.obj", "gone.png is missing")
def _(file: Path) -> None:
    textured_box().export(file, mtl_name="m.mtl")
    (file.parent / "m.mtl").write_text("newmtl checker\nKd 0.8 0.8 0.8\nmap_Kd gone.png\n")


@makes("broken_picture.obj", "cannot be read")
def _(file: Path) -> None:
    textured_box().export(file, mtl_name="m.mtl")
    (file.parent / "m.mtl").write_text("newmtl checker\nKd 0.8 0.8 0.8\nmap_Kd torn.png\n")
    checker().save(file.parent / "torn.png")
    (file.parent / "torn.png").write_bytes((file.parent / "torn.png").read_bytes()[:60])


@makes("Größe 茶碗.obj")
def _(file: Path) -> None:
    textured_box().export(file, mtl_name="m.mtl")
    text = file.read_text().replace("m.mtl", "Stoff é.mtl").replace("checker", "Anstrich_ü")
    file.write_text(text, encoding="utf-8")
    (file.parent / "m.mtl").unlink(missing_ok=True)
    (file.parent / "Stoff é.mtl").write_text("newmtl Anstrich_ü\nKd 1 1 1\nmap_Kd Karo ß.png\n", encoding="utf-8")
    checker().save(file.parent / "Karo ß.png")


@makes("latin1.obj")
def _(file: Path) -> None:
    file.write_bytes("# Größe\no Gefäß\n".encode("latin-1") + obj_text(cup()).encode())


@makes("windows.obj")
def _(file: Path) -> None:
    file.write_bytes(b"\xef\xbb\xbf" + obj_text(cup()).replace("\n", "\r\n").encode())


@makes("really_a_glb.obj", "", refused=True)
def _(file: Path) -> None:
    file.write_bytes(exported(cup(), "glb"))


# PLY
@makes("cup_binary.ply")
def _(file: Path) -> None:
    file.write_bytes(exported(cup(), "ply"))


@makes("cup_ascii.ply")
def _(file: Path) -> None:
    file.write_bytes(exported(cup(), "ply", encoding="ascii"))


@makes("colored.ply")
def _(file: Path) -> None:
    colored_cup().export(file)


@makes("big_endian.ply")
def _(file: Path) -> None:
    points, faces = grid(12)
    head = f"ply\nformat binary_big_endian 1.0\nelement vertex {len(points)}\n"
    head += "property float x\nproperty float y\nproperty float z\n"
    head += f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    body = points.astype(">f4").tobytes() + b"".join(struct.pack(">B3i", 3, *face) for face in faces)
    file.write_bytes(head.encode() + body)


@makes("points.ply", "no triangles", refused=True)
def _(file: Path) -> None:
    trimesh.PointCloud(cup().vertices).export(file)


@makes("cut.ply", "", refused=True)
def _(file: Path) -> None:
    content = exported(cup(), "ply")
    file.write_bytes(content[: len(content) // 2])


@makes("five_million.ply", "triangles")
def _(file: Path) -> None:
    points, faces = grid(1582)
    head = f"ply\nformat binary_little_endian 1.0\nelement vertex {len(points)}\n"
    head += "property float x\nproperty float y\nproperty float z\n"
    head += f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    rows = np.empty(len(faces), np.dtype([("n", "u1"), ("f", "<i4", 3)]))
    rows["n"], rows["f"] = 3, faces
    file.write_bytes(head.encode() + points.astype("<f4").tobytes() + rows.tobytes())


# STL
@makes("cup.stl")
def _(file: Path) -> None:
    cup().export(file)


@makes("ascii.stl")
def _(file: Path) -> None:
    cup().export(file, file_type="stl_ascii")


@makes("solid_in_binary.stl")
def _(file: Path) -> None:
    file.write_bytes(b"solid, but binary".ljust(80) + exported(cup(), "stl")[80:])


@makes("bad_normals.stl")
def _(file: Path) -> None:
    content = bytearray(exported(cup(), "stl"))
    for start in range(84, len(content), 50):
        content[start : start + 12] = struct.pack("<3f", np.nan, 0, 0)
    file.write_bytes(bytes(content))


@makes("cut.stl", "is cut off", refused=True)
def _(file: Path) -> None:
    file.write_bytes(exported(cup(), "stl")[:-1000])


@makes("nothing.stl", "no triangles", refused=True)
def _(file: Path) -> None:
    file.write_bytes(b"\0" * 84)


@makes("really_text.stl", "", refused=True)
def _(file: Path) -> None:
    file.write_text("this is no mesh at all, but a note that somebody left here\n" * 3)


# OFF
@makes("cup.off")
def _(file: Path) -> None:
    cup().export(file)


@makes("comments.off")
def _(file: Path) -> None:
    file.write_text(
        "OFF # a tetrahedron\n\n4 4 6\n0 0 0\n1 0 0 # two\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 0 3 2\n"
    )


@makes("cut.off", "", refused=True)
def _(file: Path) -> None:
    file.write_text("OFF\n4 4 6\n0 0 0\n1 0 0\n0 1 0\n")


# COLLADA
@makes("cup.dae")
def _(file: Path) -> None:
    mesh = cup()
    mesh.visual = trimesh.visual.TextureVisuals(material=trimesh.visual.material.PBRMaterial(baseColorFactor=GREEN))
    mesh.export(file)


@makes("inches_z_up.dae")
def _(file: Path) -> None:
    text = exported(cup(1 / 0.0254), "dae").decode()
    asset = '<asset><unit name="inch" meter="0.0254"/><up_axis>Z_UP</up_axis></asset>'
    head, _, rest = text.partition("<asset>")
    file.write_text(head + asset + rest.partition("</asset>")[2])


@makes("torn.dae", "cannot be read as DAE", refused=True)
def _(file: Path) -> None:
    text = exported(cup(), "dae").decode()
    file.write_text(text[: len(text) // 2])


@makes("no_mesh.dae", "", refused=True)
def _(file: Path) -> None:
    file.write_text(
        '<?xml version="1.0"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1"/>'
    )


# FBX
@makes("square.fbx")
def _(file: Path) -> None:
    file.write_text(FBX)


@makes("z_up.fbx")
def _(file: Path) -> None:
    file.write_text(
        FBX.replace('"UpAxis", "int", "Integer", "",1', '"UpAxis", "int", "Integer", "",2')
        .replace('"FrontAxis", "int", "Integer", "",2', '"FrontAxis", "int", "Integer", "",1')
        .replace('"FrontAxisSign", "int", "Integer", "",1', '"FrontAxisSign", "int", "Integer", "",-1')
    )


@makes("meters.fbx", "200 m large")
def _(file: Path) -> None:
    file.write_text(
        FBX.replace('"UnitScaleFactor", "double", "Number", "",1', '"UnitScaleFactor", "double", "Number", "",100')
    )


@makes("torn.fbx", "cannot be read as FBX", refused=True)
def _(file: Path) -> None:
    file.write_text(FBX[: len(FBX) // 2])


@makes("noise.fbx", "cannot be read as FBX", refused=True)
def _(file: Path) -> None:
    file.write_bytes(b"Kaydara FBX Binary  \x00\x1a\x00" + bytes(range(256)) * 8)


# URDF
_LINK = '<link name="{name}"><visual><origin xyz="{at}" rpy="0 0 0"/><geometry>{shape}</geometry></visual></link>'


def urdf(*links: str, joints: str = "") -> str:
    """The text of a URDF file."""
    return f'<?xml version="1.0"?><robot name="thing">{"".join(links)}{joints}</robot>'


@makes("shapes.urdf")
def _(file: Path) -> None:
    cup().export(file.parent / "cup.stl")
    shapes = ('<box size="0.1 0.2 0.05"/>', '<sphere radius="0.05"/>', '<mesh filename="cup.stl" scale="2 2 -2"/>')
    links = [_LINK.format(name=f"l{i}", at=f"{0.25 * i} 0 0", shape=shape) for i, shape in enumerate(shapes)]
    joints = "".join(f'<joint name="j{i}" type="fixed"><parent link="l0"/><child link="l{i}"/></joint>' for i in (1, 2))
    file.write_text(urdf(*links, joints=joints))


@makes("missing_mesh.urdf", "gone.stl", refused=True)
def _(file: Path) -> None:
    file.write_text(urdf(_LINK.format(name="a", at="0 0 0", shape='<mesh filename="package://thing/gone.stl"/>')))


@makes("torn.urdf", "cannot be read as URDF", refused=True)
def _(file: Path) -> None:
    file.write_text(urdf(_LINK.format(name="a", at="0 0 0", shape='<box size="1 1 1"/>'))[:90])


@makes("loop.urdf", "", refused=True)
def _(file: Path) -> None:
    links = [_LINK.format(name=name, at="0 0 0", shape='<box size="0.1 0.1 0.1"/>') for name in "ab"]
    joints = '<joint name="1" type="fixed"><parent link="a"/><child link="b"/></joint>'
    joints += '<joint name="2" type="fixed"><parent link="b"/><child link="a"/></joint>'
    file.write_text(urdf(*links, joints=joints))
