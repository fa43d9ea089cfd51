"""Messages and requests that are no good."""
