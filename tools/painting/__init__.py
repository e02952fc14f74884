"""Modules of tools/paint: painting pieces of photos by hand."""
