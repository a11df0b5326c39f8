"""What a person at the robot does in a terminal: look, release, hold to run, recover.

In come the states and plans of a cell and what is held down, a key or a button; out go requests to
the bridge, and beats for as long as it is held.
"""
