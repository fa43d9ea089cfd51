"""How several bodies in one mesh lie to each other, and which of them is the part."""
