"""Whether answers depend on how finely a CAD program divides the round surfaces of a part."""
