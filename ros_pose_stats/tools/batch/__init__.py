"""Long work in pieces: for threads, processes or a cluster, now or later."""
