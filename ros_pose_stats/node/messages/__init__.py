"""Between messages and what the core works on; pure functions."""
