"""What several tests share: peers, drivers of nodes, rigs, hidden campaigns."""
