"""The modes that a recording tells by itself, beside those of the model.

In come records with the motion of their motors and a model; out go modes of the arm behind its
motors, each with its standard deviations and the model's mode of the same shape.
"""

from model_gap.modes.mode_pairs import mode_pairs, ModelMode, ModePair

__all__ = ['ModePair', 'ModelMode', 'mode_pairs']
