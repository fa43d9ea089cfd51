"""The commands, a module each, of its name: `register` adds options, `run` runs it."""
