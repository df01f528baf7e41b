"""Measured data: read a survey, calibrate, see whether what is left is noise, and name what the model lacks."""
