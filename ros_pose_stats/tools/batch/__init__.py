"""Long work in pieces: handed out to threads, processes or a cluster, and gone on with later."""
