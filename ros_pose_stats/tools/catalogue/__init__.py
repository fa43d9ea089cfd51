"""A catalogue of parts: their poses, shares and feeding numbers, in tables and on a page."""
