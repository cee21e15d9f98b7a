"""The table of settings in the documents is the one that the settings themselves print."""

from pathlib import Path

from service.settings import as_markdown

TABLE = Path(__file__).parents[2] / "docs" / "operations" / "settings.md"


def test_the_table_of_settings_is_generated():
    assert TABLE.read_text().endswith(as_markdown()), "run `make settings`"
