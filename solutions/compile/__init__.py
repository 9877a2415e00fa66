"""From a closed form's expression to a program for the machine: value and both derivatives."""
