"""Edges, shells and moments of triangle meshes."""
