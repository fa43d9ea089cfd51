"""Compiled kernels on plain arrays: numbers and status codes go out, never exceptions.

Only the outermost kernels (decorated with `entry_kernel`) are cached on disk; the
helpers that they call are compiled into them.
"""
