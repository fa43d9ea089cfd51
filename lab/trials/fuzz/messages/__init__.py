"""Messages and requests that are not quite right, sent to a node."""
