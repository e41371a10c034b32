"""What a user meets in the first hour, tried in a fresh environment: every command and every Python block of the documents, and the wheel.

`python -m tests.first_hour` runs it. It uses the standard library alone, since it must not lean on the environment that it tries.
"""
