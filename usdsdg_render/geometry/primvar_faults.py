"""Primvars of a mesh that have more values than it has elements, of which those at the end would go without a word."""

from usdsdg import errors
from usdsdg_render.geometry.mesh_source import MeshSource


def warn_of_excess(path: str, source: MeshSource) -> None:
    """Warn of texture coordinates and normals with more values than elements; readers of colors warn of those."""
    elements = {
        "uniform": len(source.counts),
        "varying": len(source.points),
        "vertex": len(source.points),
        "faceVarying": len(source.indices),
    }
    for what, primvar in (("texture coordinates", source.uvs), ("normals", source.normals)):
        if primvar is None:
            continue
        wanted, given = elements.get(primvar.interpolation), len(primvar.indices) or len(primvar.values)
        if wanted is None or given <= wanted:
            continue
        others = [name for name, count in elements.items() if count == given]
        remedy = f"Set the interpolation to {others[-1]}" if others else "Author one value for each element"
        noun = "indices" if len(primvar.indices) else "values"
        errors.warn_once(
            f"{path}: the {given} {noun} of its {primvar.interpolation} {what} are more than {wanted}; those at the "
            f"end are ignored. {remedy}."
        )
