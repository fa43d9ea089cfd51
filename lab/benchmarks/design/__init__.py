"""How right estimated and told gains of changes are, against drops."""
