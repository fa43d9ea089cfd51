"""Nodes in processes of their own, and the clients that try them."""
