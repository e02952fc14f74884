# SPDX-License-Identifier: Apache-2.0
"""The checks of tools/lint: a module per language; what they share is in common.py. A check is one function of a Work;
it returns its findings as lines, or raises SkippedError with what is missing. CHECKS in tools/lint lists all of them.
"""
