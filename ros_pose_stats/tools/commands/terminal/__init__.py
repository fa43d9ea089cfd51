"""What commands share at the terminal: what is typed, progress, Ctrl-C, and answers."""
