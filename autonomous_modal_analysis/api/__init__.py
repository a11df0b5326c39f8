"""The Python API: arrays, recordings and robots in, results with numbers, tables and pictures out.

The public names are those of :mod:`autonomous_modal_analysis`; the command line calls the same
functions.  Nothing is imported here: a robot's model loads a library of rigid bodies, a picture
matplotlib, and who needs neither waits for neither.
"""
