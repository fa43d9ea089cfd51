"""Commands for whoever changes a part: `compare` and `sensitivity`."""
