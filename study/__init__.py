"""The paper's study done again; not installed."""
