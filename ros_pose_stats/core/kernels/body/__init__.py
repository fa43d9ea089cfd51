"""Convex bodies: their faces, their equilibria, and how they topple."""
