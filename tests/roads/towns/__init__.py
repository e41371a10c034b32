"""Towns made here, as dirty as those that everyone in simulation uses: OpenDRIVE and CommonRoad files as text."""
