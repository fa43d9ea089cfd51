"""Figures, each a small function on records or plain arrays; the only room with matplotlib."""
