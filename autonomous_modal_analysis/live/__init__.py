"""The cell live: nodes started and ended, a person's release, what they say recorded.

In come the commands of the nodes and a plan; out go running processes and recordings.
"""
