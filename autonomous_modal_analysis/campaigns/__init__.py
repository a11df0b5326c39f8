"""Campaigns: poses times levels, each recorded by a plan of its own.

In come a robot and limits; out go poses, plans and a folder of recordings that can be
gone on with.
"""
