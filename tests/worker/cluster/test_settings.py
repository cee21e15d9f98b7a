"""Settings that are wrong are named, in words."""

import pytest

from service.settings import Settings
from worker.cluster.settings import ClusterSettings
from worker.errors import InvalidSettings


@pytest.mark.parametrize(
    ("settings", "variable", "value", "told"),
    [
        (ClusterSettings, "RATTLE_WORKERS", "abc", "RATTLE_WORKERS: Input should be a valid integer"),
        (ClusterSettings, "RATTLE_WORKERS", "0", "greater than 0, not '0'"),
        (ClusterSettings, "RATTLE_SCHEDULER", "tls://host:8786", "all three: `rattle certs` makes them"),
        (Settings, "RATTLE_LOG_LEVEL", "foo", "RATTLE_LOG_LEVEL: Input should be 'debug', 'info'"),
        (Settings, "RATTLE_PORT", "99999", "RATTLE_PORT: Input should be less than or equal to 65535, not '99999'"),
    ],
)
def test_a_wrong_setting_is_named_without_pydantics_words(monkeypatch, settings, variable, value, told):
    monkeypatch.setenv(variable, value)
    with pytest.raises(InvalidSettings) as refused:
        settings()
    assert told in str(refused.value)
    assert not [
        word for word in ("errors.pydantic.dev", "Value error", "\n", "input_type") if word in str(refused.value)
    ]


def test_a_setting_given_as_an_argument_is_named_as_the_argument():
    with pytest.raises(InvalidSettings, match="^port: Input should be a valid integer"):
        Settings(port="no")
