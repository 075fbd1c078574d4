"""Faces too narrow to tell their own shape: the faces beside them tell it."""
