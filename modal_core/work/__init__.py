"""How work is done: side by side, beside this process, compiled, before all others.

In come functions and items; out go their results in order.
"""
