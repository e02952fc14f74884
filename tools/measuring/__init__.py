# SPDX-License-Identifier: Apache-2.0
"""The sub-commands of tools/measure: a module each with add_arguments() and run(); what they share is in common.py."""
