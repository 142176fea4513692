"""Parts of Newton's solver in forms that are faster on the CPU and give the same bits."""
