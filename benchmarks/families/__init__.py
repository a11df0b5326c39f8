"""Random families of structures, their records, and what an identifier makes of them."""
