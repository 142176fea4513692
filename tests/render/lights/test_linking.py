"""Light linking and ShadowAPI: from USD to rows to images."""

from __future__ import annotations

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom, UsdLux

from tests.render import scenes
from tests.render.images import radiance
from usdsdg_render.lights.linking import read_links
from usdsdg_render.scene.scene import LightLinks
from usdsdg_render.scene.structs import LIGHT_DISTANT, LIGHT_RECT, LIGHT_SPHERE
from usdsdg_render.sync.extract import SceneExtractor

# A floor of two instances, and a plate above the left one.
HEIGHT = 2.0
LIGHTS = {
    "delta": dict(kind=LIGHT_DISTANT, radiance=10.0, cos_angle=1.0),
    "cone": dict(kind=LIGHT_DISTANT, radiance=4000.0, cos_angle=np.cos(np.radians(2.0))),
    "sphere": dict(kind=LIGHT_SPHERE, radiance=2000.0, position=(0, 0, 9.0), radius=0.4),
    "rect": dict(kind=LIGHT_RECT, radiance=2000.0, position=(0, 0, 9.0), width=0.8, height=0.8),
}


def lit_floor(light: str, links: LightLinks | None, *, plate: bool, floor=None, bounces=2) -> np.ndarray:
    """Mean radiance (3,) at the origin of a floor (instance 0), a plate (instance 1) hanging over it or not."""
    floor = scenes.material(base_color=0.5, specular=0.0, roughness=1.0) if floor is None else floor
    placed = [(scenes.square(), scenes.moved(scale=20.0), 0)]
    if plate:
        placed.append((scenes.cube(), scenes.moved((0, 0, HEIGHT + 0.05), scale=(1.5, 1.5, 0.05)), 1))
    row = scenes.light(visible=0, **LIGHTS[light])
    dark = scenes.material(base_color=0.0, specular=0.0)
    scene = scenes.scene_of(placed, materials=[floor, dark], lights=[row])
    if links is not None:
        scene.light_links, scene.lights["links"] = [links], 0
    view = scenes.view_from((0.0, -8.0, 1.2), size=(1, 1), focal_length=50000.0)
    return radiance(scene, view, samples=1024, bounces=bounces).mean((0, 1))


FLOORS = {
    "matt": scenes.material(base_color=0.5, specular=0.0, roughness=1.0),
    "glossy": scenes.material(base_color=0.2, specular=0.5, roughness=0.3),
}


@pytest.mark.parametrize("floor", FLOORS)
@pytest.mark.parametrize("light", LIGHTS)
def test_a_light_without_shadows_is_not_occluded(light, floor):
    material = FLOORS[floor]
    open_sky = lit_floor(light, None, plate=False, floor=material)
    assert lit_floor(light, None, plate=True, floor=material).max() < 0.02 * open_sky.max()
    through = lit_floor(light, LightLinks(shadow_distance=0.0), plate=True, floor=material)
    np.testing.assert_allclose(through, open_sky, rtol=0.02)


@pytest.mark.parametrize("floor", FLOORS)
@pytest.mark.parametrize("light", ["delta", "sphere"])
def test_shadows_have_their_color(light, floor):
    material = FLOORS[floor]
    open_sky = lit_floor(light, None, plate=False, floor=material)
    shadow = lit_floor(light, LightLinks(shadow_color=(0.2, 0.5, 1.0)), plate=True, floor=material)
    np.testing.assert_allclose(shadow, open_sky * (0.2, 0.5, 1.0), rtol=0.02)


def test_shadows_end_and_fade_with_the_distance_of_the_occluder():
    """The plate is two units above: full shadow before the falloff zone, none past the distance, a power between."""
    open_sky = lit_floor("delta", None, plate=False)[0]

    def left(**links) -> float:
        return lit_floor("delta", LightLinks(**links), plate=True)[0] / open_sky

    assert left(shadow_distance=2.1) < 1e-3
    assert left(shadow_distance=1.9) == pytest.approx(1.0, abs=1e-3)
    assert left(shadow_distance=4.0, shadow_falloff=1.5) < 1e-3
    assert left(shadow_distance=3.0, shadow_falloff=2.0) == pytest.approx(1 - 0.5, abs=2e-3)
    assert left(shadow_distance=3.0, shadow_falloff=2.0, shadow_gamma=3.0) == pytest.approx(1 - 0.5**3, abs=2e-3)


@pytest.mark.parametrize("floor", FLOORS)
@pytest.mark.parametrize("light", LIGHTS)
def test_lights_illuminate_linked_instances_only(light, floor):
    material = FLOORS[floor]
    open_sky = lit_floor(light, None, plate=False, floor=material)
    assert lit_floor(light, LightLinks(lit=np.array([False])), plate=False, floor=material).max() == 0.0
    linked = lit_floor(light, LightLinks(lit=np.array([True])), plate=False, floor=material)
    np.testing.assert_allclose(linked, open_sky, rtol=0.02)


@pytest.mark.parametrize("light", LIGHTS)
def test_only_linked_instances_cast_a_shadow(light):
    open_sky = lit_floor(light, None, plate=False)
    free = lit_floor(light, LightLinks(casting=np.array([True, False])), plate=True)
    np.testing.assert_allclose(free, open_sky, rtol=0.02)
    assert lit_floor(light, LightLinks(casting=np.array([False, True])), plate=True).max() < 0.02 * open_sky.max()


def test_a_linked_light_does_not_affect_other_lights():
    plain = scenes.sphere_light(500.0, (1, 0, 5), 0.3, visible=0)
    ruled = scenes.sphere_light(900.0, (-1, 0, 5), 0.3, visible=0, links=0)
    view = scenes.view_from((0.0, -8.0, 1.2), size=(1, 1), focal_length=50000.0)
    placed = [(scenes.square(), scenes.moved(scale=20.0), 0)]

    def seen(lights) -> float:
        scene = scenes.scene_of(placed, lights=lights)
        scene.light_links = [LightLinks(lit=np.array([False]))]
        return radiance(scene, view, samples=4096, bounces=2).mean()

    np.testing.assert_allclose(seen([plain, ruled]), seen([plain]), rtol=0.02)


def test_glass_shows_a_linked_light_once():
    """Every face of a slab traces its own ray toward the light behind it; only the last one sees it."""
    glass = scenes.material(base_color=1.0, specular=0.04, roughness=0.0, transmission=1.0, ior=1.5)
    light = scenes.light(LIGHT_RECT, radiance=10.0, position=(0, 0, -4.0), width=6.0, height=6.0)
    light["z_axis"], light["y_axis"] = (0, 0, -1), (0, -1, 0)
    slab = (scenes.cube(), scenes.moved(scale=(2.0, 2.0, 0.2)), 0)
    view = scenes.view_from((0.0, 0.1, 5.0), size=(4, 4), focal_length=100.0)

    def seen(links: int) -> float:
        light["links"] = links
        scene = scenes.scene_of([slab], materials=[glass], lights=[light])
        scene.light_links = [LightLinks(casting=np.array([True]))]
        return radiance(scene, view, samples=512, bounces=4).mean()

    plain = seen(-1)
    assert 8.0 < plain < 10.0
    assert seen(0) == pytest.approx(plain, rel=0.01)


# From USD


def stage_of_two() -> tuple[Usd.Stage, UsdLux.SphereLight]:
    stage = Usd.Stage.CreateInMemory()
    for name in ("A", "B"):
        UsdGeom.Cube.Define(stage, f"/World/{name}/Cube")
    light = UsdLux.SphereLight.Define(stage, "/World/Light")
    light.CreateIntensityAttr(10.0)
    return stage, light


PATHS = ["/World/A/Cube", "/World/B/Cube"]


def test_plain_lights_have_no_links():
    _, light = stage_of_two()
    UsdLux.ShadowAPI.Apply(light.GetPrim()).CreateShadowEnableAttr(True)
    assert read_links(light.GetPrim(), PATHS) is None


def test_excluded_prims_are_not_lit():
    _, light = stage_of_two()
    UsdLux.LightAPI(light).GetLightLinkCollectionAPI().ExcludePath("/World/B")
    links = read_links(light.GetPrim(), PATHS)
    assert links is not None
    assert links.lit is not None
    assert links.lit.tolist() == [True, False]
    assert links.casting is None


def test_without_the_root_only_included_prims_cast_shadows():
    _, light = stage_of_two()
    shadow = UsdLux.LightAPI(light).GetShadowLinkCollectionAPI()
    shadow.GetIncludeRootAttr().Set(False)
    shadow.IncludePath("/World/B")
    links = read_links(light.GetPrim(), PATHS)
    assert links is not None
    assert links.casting is not None
    assert links.casting.tolist() == [False, True]
    assert links.lit is None


@pytest.mark.parametrize("expression", ["", "/World/A//", "//Cube"])
@pytest.mark.parametrize("includes", [[], ["/World/A"], ["/World/A/Cube"], ["/World/B", "/World/A/Cube"]])
@pytest.mark.parametrize("root", [True, False])
@pytest.mark.parametrize("rule", ["expandPrims", "explicitOnly"])
@pytest.mark.parametrize("mode", ["automatic", "relationship", "expression"])
def test_links_have_the_members_that_usd_gives_a_collection(mode, rule, root, includes, expression):
    stage, light = stage_of_two()
    collection = UsdLux.LightAPI(light).GetLightLinkCollectionAPI()
    collection.CreateModeAttr(mode)
    collection.CreateExpansionRuleAttr(rule)
    collection.CreateIncludeRootAttr(root)
    collection.CreateIncludesRel().SetTargets(includes)
    if expression:
        collection.CreateMembershipExpressionAttr(Sdf.PathExpression(expression))
    members = Usd.CollectionAPI.ComputeIncludedPaths(collection.ComputeMembershipQuery(), stage)
    links = read_links(light.GetPrim(), PATHS)
    lit = [True, True] if links is None or links.lit is None else links.lit.tolist()
    assert lit == [Sdf.Path(path) in members for path in PATHS]


def test_shadow_inputs_are_read():
    _, light = stage_of_two()
    shadow = UsdLux.ShadowAPI.Apply(light.GetPrim())
    shadow.CreateShadowColorAttr(Gf.Vec3f(0.5, 0.25, 0))
    shadow.CreateShadowDistanceAttr(4.0)
    shadow.CreateShadowFalloffAttr(9.0)
    shadow.CreateShadowFalloffGammaAttr(2.0)
    links = read_links(light.GetPrim(), PATHS)
    assert links is not None
    # The falloff zone is at most the distance.
    assert (links.shadow_distance, links.shadow_falloff, links.shadow_gamma) == (4.0, 4.0, 2.0)
    assert links.shadow_color == (0.5, 0.25, 0.0)
    shadow.CreateShadowEnableAttr(False)
    links = read_links(light.GetPrim(), PATHS)
    assert links is not None
    assert links.shadow_distance == 0.0


def test_links_follow_the_stage():
    stage, light = stage_of_two()
    UsdLux.LightAPI(light).GetLightLinkCollectionAPI().ExcludePath("/World/B")
    extractor = SceneExtractor(stage)
    extractor.update()
    scene = extractor.scene
    assert scene.lights["links"].tolist() == [0]
    assert scene.light_links[0].lit.tolist() == [True, False]
    before = scene.versions["lights"]
    extractor.update()
    assert scene.versions["lights"] == before
    # One more instance, also lit.
    UsdGeom.Sphere.Define(stage, "/World/A/Ball")
    extractor.update()
    assert dict(zip(scene.instances.paths, scene.light_links[0].lit.tolist(), strict=True)) == {
        "/World/A/Cube": True,
        "/World/A/Ball": True,
        "/World/B/Cube": False,
    }
    # A link is removed.
    UsdLux.LightAPI(light).GetLightLinkCollectionAPI().GetExcludesRel().SetTargets([])
    extractor.update()
    assert scene.lights["links"].tolist() == [-1]
    assert scene.light_links == []
    # An instance is removed by a degenerate transform.
    UsdLux.LightAPI(light).GetLightLinkCollectionAPI().ExcludePath("/World/B")
    ball = UsdGeom.Xformable(stage.GetPrimAtPath("/World/A/Ball"))
    scale = ball.AddScaleOp()
    scale.Set(Gf.Vec3f(1))
    extractor.update()
    scale.Set(Gf.Vec3f(0))
    with pytest.warns(UserWarning, match="/World/A/Ball"):
        extractor.update()
    assert scene.light_links[0].lit.tolist() == [True, False]
    extractor.close()


def test_point_instances_are_linked_by_their_prototypes():
    stage, light = stage_of_two()
    instancer = UsdGeom.PointInstancer.Define(stage, "/World/Many")
    UsdGeom.Cube.Define(stage, "/World/Many/Cube")
    instancer.CreatePrototypesRel().SetTargets(["/World/Many/Cube"])
    instancer.CreatePositionsAttr([(0, 0, 0), (5, 0, 0)])
    instancer.CreateProtoIndicesAttr([0, 0])
    UsdLux.LightAPI(light).GetLightLinkCollectionAPI().ExcludePath("/World/Many")
    extractor = SceneExtractor(stage)
    extractor.update()
    lit = dict(zip(extractor.scene.instances.paths, extractor.scene.light_links[0].lit.tolist(), strict=True))
    assert [lit[path] for path in PATHS] == [True, True]
    assert sum(lit.values()) == 2
    assert len(lit) == 4
    extractor.close()
