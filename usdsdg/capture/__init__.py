"""One captured frame: which render products are drawn, with which samples, and who receives the result."""
