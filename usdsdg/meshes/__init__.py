"""Meshes of other forms as USD: OBJ, glTF, PLY, STL, COLLADA, FBX and URDF, converted once and cached."""
