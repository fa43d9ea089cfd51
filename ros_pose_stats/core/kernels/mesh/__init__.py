"""Edges, shells, areas and moments of triangle meshes."""
