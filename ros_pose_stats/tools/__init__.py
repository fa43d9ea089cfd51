"""What a person uses: commands, pages, pictures, variants of a part, analysis of bags."""
