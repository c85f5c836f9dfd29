"""Selections and comparisons as files: lists, captures that trainers read, pages to look at."""
