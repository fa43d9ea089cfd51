"""Features of surfaces and of splits, measured."""
