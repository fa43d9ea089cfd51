"""The commands, a module each, of its name: `register` adds its options, `run` runs it."""
