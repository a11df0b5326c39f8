"""The findings of Jiao et al. (2025), doi:10.1038/s41598-025-95339-6, computed anew.

One module per finding; ``python -m examples.paper`` runs them all.  Each computes its figures in
one function, prints them as a table and draws them; docs/explanation/paper.md compares
them with the paper.
"""
