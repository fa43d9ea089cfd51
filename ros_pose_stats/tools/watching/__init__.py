"""A page on a local address that follows the file of a part while it is designed."""
