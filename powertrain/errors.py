"""The one exception that a vehicle or its description can raise."""


class VehicleError(ValueError):
    """A vehicle description that cannot be used.

    The message is one line: which file, which key, what was found, what was expected.
    """
