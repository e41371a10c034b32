"""Tests of the path planner on hard random roads."""
