"""Many recordings at once, each a file of its own: `ama batch`.

In come paths and what to ask of every recording; out come a folder of results each, a manifest
with a row per recording, and their results in a history.  The unit of work is one recording; only
paths and rows travel.  Dask distributed hands the work to processes, here or on other machines,
and again where one was killed (https://distributed.dask.org, "Resilience").
"""
