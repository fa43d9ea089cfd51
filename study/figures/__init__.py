"""Figures of the study: those of the paper, of tables and walks, and the chart."""
