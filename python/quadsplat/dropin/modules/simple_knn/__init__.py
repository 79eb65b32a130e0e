# SPDX-License-Identifier: MIT
"""simple_knn, by quadsplat."""
