"""The task as people have it: in come files and settings; out go a tool and a cut in SI units."""

from machining.task.make_cut import axes_of, cut_of, speeds_of
from machining.task.response_file import read_response, ToolResponse
from machining.task.tool_file import read_tool_modes

__all__ = [
    'ToolResponse',
    'axes_of',
    'cut_of',
    'read_response',
    'read_tool_modes',
    'speeds_of',
]
