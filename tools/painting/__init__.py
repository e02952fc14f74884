# SPDX-License-Identifier: Apache-2.0
"""Modules of tools/paint: painting pieces of photos by hand."""
