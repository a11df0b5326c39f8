"""Effects hidden in arms, and how often the search names them."""
