"""The study's figures: the paper's, those of its tables, and the chart."""
