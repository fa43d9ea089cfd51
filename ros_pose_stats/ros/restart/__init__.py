"""What a node takes over from the bags of earlier runs."""
