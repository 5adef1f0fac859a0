"""Fixtures of the tests of the plain models."""

import pytest

from tests.reference import plain_model


@pytest.fixture(params=["package", "database"])
def tables(request):
    """The tables that the package ships, and those of the database."""
    if request.param == "database":
        return request.getfixturevalue("database_tables")
    return plain_model.airframe_tables()
