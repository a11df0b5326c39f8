"""Maps of the workspace and stability lobes on arms whose truth is known."""
