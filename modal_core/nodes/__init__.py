"""What the nodes of every room share: their life, their parameters, their subscriptions.

In come a way to make a node and its parameters; out go a process that ends cleanly, and messages.
"""
