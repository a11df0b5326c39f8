"""Where a robot's model and its recordings disagree, and why.

In come a model and a campaign of recordings; out go a verdict, the effect that explains the gap
where one can be named, and the corrected model.
"""
