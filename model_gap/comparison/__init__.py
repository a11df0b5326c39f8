"""Model and measurement side by side, each figure with its uncertainty."""

from model_gap.comparison.compare import compare, Comparison

__all__ = ['Comparison', 'compare']
