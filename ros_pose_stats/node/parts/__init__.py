"""What parts the node knows, and the best result of each."""
