"""Drop simulation: from starting directions to counted poses, on all cores."""
