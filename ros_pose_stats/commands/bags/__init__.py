"""What the command `bag` prints of recorded runs."""
