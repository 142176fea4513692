"""Parts of Newton's collision pipeline and solver in forms that are faster on the CPU and give the same bits."""
