"""How the command line is read: types of arguments, options of a part, helps."""
