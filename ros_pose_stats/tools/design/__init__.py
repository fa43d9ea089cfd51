"""Changing a part: variants side by side, and which change feeds better."""
