"""The benchmark: datasets, tables, figures and the chart of speed against accuracy."""
