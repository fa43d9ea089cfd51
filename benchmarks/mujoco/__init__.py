"""The settings of MuJoCo that the package compares itself with, tried out."""
