"""What clients ask for: services, actions and what the node says of its health."""
