"""How far points, surfaces and shapes are from each other."""
