"""Result stores of batches, for the tests of tests/house; read by a foreign library."""
import contextlib
import sqlite3


def rows(database):
    """Every row of every table, save what belongs to the machine."""
    with contextlib.closing(sqlite3.connect(database)) as connection:
        tables = [name for name, in connection.execute("SELECT name FROM sqlite_schema WHERE type = 'table' ORDER BY name")]
        assert "episodes" in tables and "metrics" in tables
        assert connection.execute("PRAGMA integrity_check").fetchall() == [("ok",)]
        return {t: sorted(map(repr, connection.execute(f"SELECT * FROM {t}"))) for t in tables if t != "timing"}
