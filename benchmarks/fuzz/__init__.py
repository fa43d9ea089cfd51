"""Meshes of every bad kind, the invariants they must keep, and a guard against hanging."""
