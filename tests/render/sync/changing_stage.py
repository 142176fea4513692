"""A small stage with a bit of everything that may change, and edits of it that may come in any order, many times."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
from PIL import Image
from pxr import Gf, Sdf, Usd, UsdGeom, UsdLux, UsdShade, UsdSkel

from tests.stage.geometry.characters import add_character
from usdsdg.stage.semantics.labels import add_labels, remove_labels

Edit = Callable[[Usd.Stage, int], object]
COLORS = [Gf.Vec3f(0.9, 0.1, 0.1), Gf.Vec3f(0.1, 0.8, 0.2), Gf.Vec3f(0.2, 0.3, 0.9)]
QUAD = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], float)


def make_stage(folder: Path) -> Usd.Stage:
    """All of it within three units of the origin, seen from above by /World/Camera."""
    for k in range(3):
        rng = np.random.default_rng(k)
        Image.fromarray(rng.integers(0, 256, (8, 8, 3), np.uint8)).save(folder / f"{k}.png")
    _write_asset(folder)
    stage = Usd.Stage.CreateNew(str(folder / "stage.usda"))
    UsdGeom.SetStageUpAxis(stage, "Z")
    UsdGeom.Xform.Define(stage, "/World").AddTranslateOp().Set(Gf.Vec3d(0))
    _add_materials(stage, folder)
    _add_meshes(stage)
    for k in range(3):
        _add_reference(stage, f"/World/Crates/c{k}", folder, k, instanceable=k > 0)
    _add_points(stage)
    varied = UsdGeom.Xform.Define(stage, "/World/Varied")
    varied.AddTranslateOp().Set(Gf.Vec3d(-2, 2, 0))
    shapes = varied.GetPrim().GetVariantSets().AddVariantSet("shape")
    for name, kind in (("ball", "Sphere"), ("box", "Cube"), ("none", "")):
        shapes.AddVariant(name)
        shapes.SetVariantSelection(name)
        with shapes.GetVariantEditContext():
            if kind:
                stage.DefinePrim("/World/Varied/Shape", kind)
                UsdGeom.Xformable(stage.GetPrimAtPath("/World/Varied/Shape")).AddScaleOp().Set(Gf.Vec3f(0.4))
    shapes.SetVariantSelection("ball")
    add_character(stage, "/World/Man")
    UsdGeom.Xformable(stage.GetPrimAtPath("/World/Man")).AddTranslateOp().Set(Gf.Vec3d(2, 2, 0))
    _add_lights(stage, folder)
    camera = UsdGeom.Camera.Define(stage, "/World/Camera")
    camera.AddTranslateOp().Set(Gf.Vec3d(0, 0, 9))
    camera.CreateClippingRangeAttr(Gf.Vec2f(0.01, 100))
    camera.CreateFocalLengthAttr(24.0)
    return stage


def _write_asset(folder: Path) -> None:
    asset = Usd.Stage.CreateNew(str(folder / "crate.usda"))
    asset.SetDefaultPrim(UsdGeom.Xform.Define(asset, "/Crate").GetPrim())
    _mesh(asset, "/Crate/Mesh", QUAD * 0.5)
    box = UsdGeom.Cube.Define(asset, "/Crate/Box")
    box.CreateSizeAttr(0.4)
    box.AddTranslateOp().Set(Gf.Vec3d(0, 0, 0.4))
    _add_material(asset, "/Crate/Look", COLORS[1])
    UsdShade.MaterialBindingAPI.Apply(box.GetPrim()).Bind(UsdShade.Material.Get(asset, "/Crate/Look"))
    asset.Save()


def _mesh(stage: Usd.Stage, path: str, points: np.ndarray) -> UsdGeom.Mesh:
    mesh = UsdGeom.Mesh.Define(stage, path)
    mesh.CreatePointsAttr([Gf.Vec3f(*p) for p in points.tolist()])
    mesh.CreateFaceVertexCountsAttr([3, 3])
    mesh.CreateFaceVertexIndicesAttr([0, 1, 2, 0, 2, 3])
    mesh.CreateSubdivisionSchemeAttr("none")
    st = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar("st", Sdf.ValueTypeNames.TexCoord2fArray, "vertex")
    st.Set([Gf.Vec2f(0, 0), Gf.Vec2f(1, 0), Gf.Vec2f(1, 1), Gf.Vec2f(0, 1)])
    return mesh


def _add_material(stage: Usd.Stage, path: str, color: Gf.Vec3f, file: str = "") -> None:
    material = UsdShade.Material.Define(stage, path)
    surface = UsdShade.Shader.Define(stage, f"{path}/Surface")
    surface.CreateIdAttr("UsdPreviewSurface")
    diffuse = surface.CreateInput("diffuseColor", Sdf.ValueTypeNames.Color3f)
    diffuse.Set(color)
    surface.CreateInput("roughness", Sdf.ValueTypeNames.Float).Set(0.5)
    if file:
        texture = UsdShade.Shader.Define(stage, f"{path}/Tex")
        texture.CreateIdAttr("UsdUVTexture")
        texture.CreateInput("file", Sdf.ValueTypeNames.Asset).Set(file)
        diffuse.ConnectToSource(texture.ConnectableAPI(), "rgb")
    material.CreateSurfaceOutput().ConnectToSource(surface.ConnectableAPI(), "surface")


def _add_materials(stage: Usd.Stage, folder: Path) -> None:
    _add_material(stage, "/World/Looks/plain", COLORS[0])
    _add_material(stage, "/World/Looks/textured", COLORS[1], str(folder / "0.png"))


def _add_meshes(stage: Usd.Stage) -> None:
    ground = _mesh(stage, "/World/Ground", QUAD * 4 - [0, 0, 1])
    UsdShade.MaterialBindingAPI.Apply(ground.GetPrim()).Bind(UsdShade.Material.Get(stage, "/World/Looks/textured"))
    parted = _mesh(stage, "/World/Parted", QUAD * 0.7)
    parted.AddTranslateOp().Set(Gf.Vec3d(-2, -2, 0.5))
    UsdGeom.Subset.CreateGeomSubset(parted, "half", "face", [0], "materialBind", "partition")
    half = stage.GetPrimAtPath("/World/Parted/half")
    UsdShade.MaterialBindingAPI.Apply(half).Bind(UsdShade.Material.Get(stage, "/World/Looks/plain"))
    for k in range(3):
        ball = UsdGeom.Sphere.Define(stage, f"/World/Balls/b{k}")
        ball.CreateRadiusAttr(0.4)
        ball.AddTranslateOp().Set(Gf.Vec3d(k - 1, 0, 0))
        ball.CreateDisplayColorAttr([COLORS[k]])


def _add_reference(stage: Usd.Stage, path: str, folder: Path, k: int, *, instanceable: bool) -> None:
    prim = UsdGeom.Xform.Define(stage, path).GetPrim()
    prim.GetReferences().AddReference(str(folder / "crate.usda"))
    prim.SetInstanceable(instanceable)
    xformable = UsdGeom.Xformable(prim)
    xformable.ClearXformOpOrder()
    UsdGeom.XformCommonAPI(prim).SetTranslate(Gf.Vec3d(k - 1, -2, 0))


def _add_points(stage: Usd.Stage) -> None:
    instancer = UsdGeom.PointInstancer.Define(stage, "/World/Points")
    grain = UsdGeom.Sphere.Define(stage, "/World/Points/Grain")
    grain.CreateRadiusAttr(0.15)
    grain.AddTranslateOp().Set(Gf.Vec3d(0))
    # This prototype is drawn where it stands too.
    instancer.CreatePrototypesRel().SetTargets(["/World/Points/Grain", "/World/Balls/b2"])
    instancer.CreateProtoIndicesAttr([0, 1, 0])
    instancer.CreatePositionsAttr([Gf.Vec3f(k - 1, 1.5, 0) for k in range(3)])


def _add_lights(stage: Usd.Stage, folder: Path) -> None:
    lamp = UsdLux.SphereLight.Define(stage, "/World/Lamp")
    lamp.CreateIntensityAttr(3000)
    lamp.CreateColorAttr(Gf.Vec3f(1))
    lamp.CreateRadiusAttr(0.2)
    lamp.AddTranslateOp().Set(Gf.Vec3d(0, 0, 3))
    UsdLux.DistantLight.Define(stage, "/World/Sun").CreateIntensityAttr(500)
    sky = UsdLux.DomeLight.Define(stage, "/World/Sky")
    sky.CreateIntensityAttr(200)
    sky.CreateTextureFileAttr(str(folder / "1.png"))
    sky.AddRotateZOp().Set(0.0)


def _set(path: str, *values: object) -> Edit:
    return lambda stage, k: stage.GetAttributeAtPath(path).Set(values[k % len(values)])


def _toggle_visibility(path: str) -> Edit:
    def edit(stage: Usd.Stage, k: int) -> None:
        attribute = UsdGeom.Imageable(stage.GetPrimAtPath(path)).CreateVisibilityAttr()
        attribute.Set("inherited" if attribute.Get() == "invisible" else "invisible")

    return edit


def _bind(path: str, stronger: bool = False) -> Edit:
    def edit(stage: Usd.Stage, k: int) -> None:
        material = UsdShade.Material.Get(stage, f"/World/Looks/{('plain', 'textured')[k % 2]}")
        strength = UsdShade.Tokens.strongerThanDescendants if stronger and k % 3 else UsdShade.Tokens.fallbackStrength
        UsdShade.MaterialBindingAPI.Apply(stage.GetPrimAtPath(path)).Bind(material, strength)

    return edit


def _bind_by_collection(stage: Usd.Stage, k: int) -> None:
    collection = Usd.CollectionAPI.Apply(stage.GetPrimAtPath("/World/Looks"), "some")
    collection.CreateIncludesRel().SetTargets([f"/World/Balls/b{k % 3}"])
    material = UsdShade.Material.Get(stage, "/World/Looks/plain")
    UsdShade.MaterialBindingAPI.Apply(stage.GetPrimAtPath("/World/Balls")).Bind(collection, material, "some")


def _bind_to_a_later_material(stage: Usd.Stage, k: int) -> None:
    """A binding first, then its material, which may go again."""
    api = UsdShade.MaterialBindingAPI.Apply(stage.GetPrimAtPath("/World/Balls/b0"))
    api.GetDirectBindingRel().SetTargets([Sdf.Path("/World/Later")])
    if k % 2:
        _add_material(stage, "/World/Later", COLORS[k % 3])
    else:
        stage.RemovePrim("/World/Later")


def _reference(stage: Usd.Stage, k: int) -> None:
    """One more crate, or one less, with or without instancing."""
    path = f"/World/Crates/new{k % 3}"
    if stage.GetPrimAtPath(path):
        stage.RemovePrim(path)
    else:
        folder = Path(stage.GetRootLayer().realPath).parent
        _add_reference(stage, path, folder, k % 4, instanceable=bool(k % 2))


def _label(stage: Usd.Stage, k: int) -> None:
    prim = stage.GetPrimAtPath("/World/Balls/b1")
    remove_labels(prim)
    add_labels(prim, {"class": f"ball_{k}"})


def _edit_asset(stage: Usd.Stage, k: int) -> None:
    asset = Usd.Stage.Open(str(Path(stage.GetRootLayer().realPath).with_name("crate.usda")))
    match k % 4:
        case 0:
            UsdGeom.Cube(asset.GetPrimAtPath("/Crate/Box")).GetSizeAttr().Set(0.3 + 0.1 * (k % 3))
        case 1:
            asset.GetAttributeAtPath("/Crate/Look/Surface.inputs:diffuseColor").Set(COLORS[k % 3])
        case 2:
            asset.GetAttributeAtPath("/Crate/Box.xformOp:translate").Set(Gf.Vec3d(0, 0, 0.3 + 0.1 * (k % 2)))
        case 3:
            if asset.GetPrimAtPath("/Crate/Extra"):
                asset.RemovePrim("/Crate/Extra")
            else:
                UsdGeom.Cone.Define(asset, "/Crate/Extra").CreateRadiusAttr(0.2)


def _subset(stage: Usd.Stage, k: int) -> None:
    if k % 2:
        stage.RemovePrim("/World/Parted/half")
    else:
        mesh = UsdGeom.Mesh(stage.GetPrimAtPath("/World/Parted"))
        subset = UsdGeom.Subset.CreateGeomSubset(mesh, "half", "face", [k % 2], "materialBind", "partition")
        UsdShade.MaterialBindingAPI.Apply(subset.GetPrim()).Bind(UsdShade.Material.Get(stage, "/World/Looks/plain"))


def _points(stage: Usd.Stage, k: int) -> None:
    positions = [Gf.Vec3f(n - 1, 1.2 + 0.1 * k, 0.1 * n) for n in range(3)]
    stage.GetAttributeAtPath("/World/Points.positions").Set(positions)


def _vary(stage: Usd.Stage, k: int) -> None:
    names = ("box", "none", "ball")
    stage.GetPrimAtPath("/World/Varied").GetVariantSet("shape").SetVariantSelection(names[k % 3])


def _reorder(stage: Usd.Stage, k: int) -> None:
    order = [f"b{(n + k) % 3}" for n in range(3)]
    stage.GetPrimAtPath("/World/Balls").SetChildrenReorder(order)


def _toggle_mesh_light(stage: Usd.Stage, k: int) -> None:
    prim = stage.GetPrimAtPath("/World/Parted")
    if k % 2:
        UsdLux.MeshLightAPI.Apply(prim)
        UsdLux.LightAPI(prim).CreateIntensityAttr(100.0 * (1 + k))
    else:
        prim.RemoveAPI(UsdLux.MeshLightAPI)


def _link(stage: Usd.Stage, k: int) -> None:
    links = UsdLux.LightAPI(stage.GetPrimAtPath("/World/Lamp")).GetLightLinkCollectionAPI()
    links.CreateExcludesRel().SetTargets(["/World/Balls"] if k % 2 else [])


def _bend(stage: Usd.Stage, k: int) -> None:
    """Another pose at time 12."""
    turn = Gf.Quatf(Gf.Rotation(Gf.Vec3d(1, 0, 0), 20.0 * (k % 4)).GetQuat())
    animation = UsdSkel.Animation(stage.GetPrimAtPath("/World/Man/Bend"))
    if animation:
        animation.GetRotationsAttr().Set([Gf.Quatf(1), turn], 12)


def _toggle_active(path: str) -> Edit:
    def edit(stage: Usd.Stage, k: int) -> None:
        prim = stage.GetPrimAtPath(path)
        if prim:
            prim.SetActive(not prim.IsActive())

    return edit


def _sample(path: str, *values: object) -> Edit:
    """Values at time 0 and 24."""

    def edit(stage: Usd.Stage, k: int) -> None:
        attribute = stage.GetAttributeAtPath(path)
        for code, value in ((0, values[k % len(values)]), (24, values[(k + 1) % len(values)])):
            attribute.Set(value, code)

    return edit


def _drift(stage: Usd.Stage, k: int) -> None:
    """Points fly on from their only sample."""
    instancer = UsdGeom.PointInstancer(stage.GetPrimAtPath("/World/Points"))
    instancer.CreateVelocitiesAttr().Set([Gf.Vec3f(0, 0, 0.2 * k)] * 3, -1)
    instancer.GetPositionsAttr().Set([Gf.Vec3f(n - 1, 1.5, 0.1 * k) for n in range(3)], -1)


def _rename(stage: Usd.Stage, k: int) -> None:
    editor = Usd.NamespaceEditor(stage)
    here = "/World/Renamed" if stage.GetPrimAtPath("/World/Renamed") else "/World/Parted2"
    there = "/World/Parted2" if here == "/World/Renamed" else "/World/Renamed"
    if not stage.GetPrimAtPath(here):
        _mesh(stage, here, QUAD * 0.3 + [2, 0, 0.5])
        return
    editor.MovePrimAtPath(here, there)
    assert editor.ApplyEdits()


EDITS: dict[str, Edit] = {
    "a pose": _set("/World/Balls/b0.xformOp:translate", Gf.Vec3d(-1, 0.5, 0.2), Gf.Vec3d(-1, 0, 0.5)),
    "a pose above all": _set("/World.xformOp:translate", Gf.Vec3d(0.3, 0, 0), Gf.Vec3d(0)),
    "a pose of an instance": _set("/World/Crates/c1.xformOp:translate", Gf.Vec3d(0, -1.5, 0), Gf.Vec3d(0, -2, 0)),
    "a pose of a prototype of points": _set("/World/Points/Grain.xformOp:translate", Gf.Vec3d(0, 0, 0.5), Gf.Vec3d(0)),
    "a pose of a shared prim": _set("/World/Balls/b2.xformOp:translate", Gf.Vec3d(1, 0, 0.6), Gf.Vec3d(1, 0, 0)),
    "a color of a material": _set("/World/Looks/plain/Surface.inputs:diffuseColor", COLORS[2], COLORS[0]),
    "a display color": lambda stage, k: stage.GetAttributeAtPath("/World/Balls/b0.primvars:displayColor").Set(
        [COLORS[k % 3]]
    ),
    "an inherited color": lambda stage, k: (
        UsdGeom.PrimvarsAPI(stage.GetPrimAtPath("/World/Crates"))
        .CreatePrimvar("displayColor", Sdf.ValueTypeNames.Color3fArray)
        .Set([COLORS[k % 3]])
    ),
    "colors of points": lambda stage, k: (
        UsdGeom.Mesh(stage.GetPrimAtPath("/World/Parted"))
        .CreateDisplayColorPrimvar("vertex")
        .Set([COLORS[(n + k) % 3] for n in range(4)])
    ),
    "a binding": _bind("/World/Parted"),
    "a binding above others": _bind("/World/Crates", stronger=True),
    "a binding of a collection": _bind_by_collection,
    "a binding to a material that comes later": _bind_to_a_later_material,
    "a texture": lambda stage, k: stage.GetAttributeAtPath("/World/Looks/textured/Tex.inputs:file").Set(
        str(Path(stage.GetRootLayer().realPath).with_name(f"{k % 3}.png"))
    ),
    "a reference": _reference,
    "an asset's own layer": _edit_asset,
    # The first instance may be the one by which USD knows their prototype.
    "an instance": _toggle_active("/World/Crates/c1"),
    "visibility": _toggle_visibility("/World/Balls/b1"),
    "visibility of many": _toggle_visibility("/World/Crates"),
    "visibility of a prototype of points": _toggle_visibility("/World/Points/Grain"),
    "visibility of a light": _toggle_visibility("/World/Lamp"),
    "purpose": lambda stage, k: (
        UsdGeom.Imageable(stage.GetPrimAtPath("/World/Balls")).CreatePurposeAttr().Set(("guide", "default")[k % 2])
    ),
    "a light's intensity": _set("/World/Lamp.inputs:intensity", 9000.0, 3000.0),
    "a light's color": _set("/World/Lamp.inputs:color", *COLORS),
    "a light's position": _set("/World/Lamp.xformOp:translate", Gf.Vec3d(1, 1, 2), Gf.Vec3d(0, 0, 3)),
    "a light's links": _link,
    "a mesh light": _toggle_mesh_light,
    "the sky's image": lambda stage, k: stage.GetAttributeAtPath("/World/Sky.inputs:texture:file").Set(
        str(Path(stage.GetRootLayer().realPath).with_name(f"{(k + 2) % 3}.png"))
    ),
    "the sky's intensity": _set("/World/Sky.inputs:intensity", 400.0, 33.0, 200.0),
    "the sky's color": lambda stage, k: (
        UsdLux.DomeLight(stage.GetPrimAtPath("/World/Sky")).CreateColorAttr().Set(COLORS[k % 3])
    ),
    "the sky's turn": _set("/World/Sky.xformOp:rotateZ", 70.0, 0.0),
    "a second sky": lambda stage, k: (
        stage.RemovePrim("/World/Sky2")
        if stage.GetPrimAtPath("/World/Sky2")
        else UsdLux.DomeLight.Define(stage, "/World/Sky2").CreateIntensityAttr(100)
    ),
    "a label": _label,
    "the camera": _set("/World/Camera.xformOp:translate", Gf.Vec3d(0.5, 0, 8), Gf.Vec3d(0, 0, 9)),
    "the lens": _set("/World/Camera.focalLength", 30.0, 24.0),
    "points of a mesh": lambda stage, k: stage.GetAttributeAtPath("/World/Parted.points").Set(
        [Gf.Vec3f(*p) for p in (QUAD * (0.5 + 0.1 * (k % 4))).tolist()]
    ),
    "a shape": _set("/World/Balls/b1.radius", 0.3, 0.5, 0.4),
    "a subset": _subset,
    "positions of points": _points,
    "a variant": _vary,
    "the order of prims": _reorder,
    "a name": _rename,
    "a skeleton": _bend,
    "a skeleton's animation": _toggle_active("/World/Man/Bend"),
    "a skeleton that goes": _toggle_active("/World/Man/Skeleton"),
    "a character": _toggle_active("/World/Man"),
    "samples of a position": _sample("/World/Balls/b1.xformOp:translate", Gf.Vec3d(0.2, 0, 0.5), Gf.Vec3d(0, 0.3, 0)),
    "samples of a prototype of points": _sample(
        "/World/Points/Grain.xformOp:translate", Gf.Vec3d(0, 0.2, 0.5), Gf.Vec3d(0, 0, 0.3)
    ),
    "samples of a shape": _sample("/World/Balls/b0.radius", 0.3, 0.6),
    "samples of a color": _sample("/World/Looks/plain/Surface.inputs:roughness", 0.1, 0.7),
    "samples of a display color": _sample("/World/Balls/b0.primvars:displayColor", COLORS[1:2], COLORS[2:]),
    "samples of visibility": lambda stage, k: (
        UsdGeom.Imageable(stage.GetPrimAtPath("/World/Balls/b2")).CreateVisibilityAttr().Set("invisible", k % 2)
    ),
    "samples of a light": _sample("/World/Lamp.inputs:intensity", 8000.0, 2000.0),
    "velocities of points": _drift,
    "up axis": lambda stage, k: UsdGeom.SetStageUpAxis(stage, "YZ"[k % 2]),
}
