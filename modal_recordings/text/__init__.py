"""Tables of numbers in text files of data loggers and spreadsheets.

In comes a file in any encoding and layout; out go its columns with the names and
units it states.
"""

from modal_recordings.text.text_encoding import encoding_of
from modal_recordings.text.text_table import read_text_table

__all__ = [
    'encoding_of',
    'read_text_table',
]
