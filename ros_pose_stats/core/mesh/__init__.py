"""From mesh files or arrays to a part."""
