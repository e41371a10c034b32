"""Driving a plan: the car as a plant, the energy manager in the loop, sensors and faults between them."""

from .drive import simulate
from .events import Event, read_events
from .log import Drive
from .sensing import SENSORS

__all__ = ["SENSORS", "Drive", "Event", "read_events", "simulate"]
