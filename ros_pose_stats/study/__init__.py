"""The paper's study done again: datasets, tables, prisms, stability, speed against accuracy."""
