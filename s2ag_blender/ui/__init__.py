"""Panels, operators, menus and properties."""
