"""Errors of this package."""


class RoadError(ValueError):
    """A road file or road geometry that cannot be used; the message says where, what was found and what was expected.

    Messages quote files, and files hold anything: what cannot be printed is escaped, and what is too long for a person is cut.
    """

    LONGEST = 1000

    def __init__(self, message: str) -> None:
        """Keep `message` on one printable line."""
        if not message.isprintable():
            message = "".join(letter if letter.isprintable() else letter.encode("unicode_escape").decode("ascii") for letter in message)
        super().__init__(message if len(message) <= self.LONGEST else message[: self.LONGEST - 3] + "...")
