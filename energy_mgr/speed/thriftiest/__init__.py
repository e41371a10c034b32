"""The speed of least energy: model, method and proof."""
