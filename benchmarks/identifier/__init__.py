"""The identifier beside the peers: speed, scatter, selection, tracking."""
