"""A catalogue of parts: poses, shares, feeding; in tables and on a page."""
