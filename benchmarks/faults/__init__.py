"""Random faults of all kinds in random places, and what becomes of the results."""
