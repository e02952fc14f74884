# SPDX-License-Identifier: Apache-2.0
"""Sub-commands of tools/measure about labels: segmentation, its training and its models."""
