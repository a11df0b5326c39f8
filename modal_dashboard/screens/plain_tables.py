"""Tables of the report kit as plain values: a browser makes text of them, never markup."""

from collections.abc import Sequence

from modal_reports import Cell, Table


def plain_table(table: Table) -> dict[str, object]:
    """Return a table whose cells are texts."""
    return {
        'label': table.label,
        'caption': table.caption,
        'empty': table.empty,
        'headings': _plain(table.headings),
        'rows': [{'kind': row.kind, 'cells': _plain(row.cells)} for row in table.rows],
    }


def _plain(cells: Sequence[Cell]) -> list[list[object]]:
    return [[str(cell.content), cell.kind, cell.span] for cell in cells]
