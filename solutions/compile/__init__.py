"""Compilation of a closed form's expression to a machine program for value and derivatives."""
