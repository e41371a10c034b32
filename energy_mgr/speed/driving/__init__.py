"""The speed while driving."""
