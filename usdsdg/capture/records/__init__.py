"""Records of captured frames and of the stage at each of them, from which datasets are verified and drawn again."""
