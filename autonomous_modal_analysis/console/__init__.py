"""What every command shares: options, the terminal, signals and streams.

In come words of a command line; out go checked options, results, progress and one line for
an error.
"""
