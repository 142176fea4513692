"""How many substeps steps take: more where joints swing, small bodies touch, near meshes, and of fast bodies."""
