"""How hard one motion hits the walls."""
