"""Joints of articulations as arrays with one row per robot: their rows, drives and properties."""
