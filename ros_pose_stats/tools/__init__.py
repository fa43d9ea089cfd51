"""What a person uses: commands, pages, pictures, variants, analysis of bags."""
