"""What every wing needs: errors, words, files, names of methods, worker processes."""
