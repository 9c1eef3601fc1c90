"""Assertion of the tests in tests/house, with its reason; optimized Python keeps it."""


def expect(condition, what):
    if not condition:
        raise AssertionError(what)
