"""The one exception that a road or a road file can raise."""


class RoadError(ValueError):
    """A road or road file that cannot be used.

    The message is one line: which file (or road), which place, what was found, what was expected.
    """
