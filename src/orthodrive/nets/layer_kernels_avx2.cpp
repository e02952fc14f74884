// SPDX-License-Identifier: Apache-2.0
#define ORTHODRIVE_LAYER_KERNELS avx2_layer_kernels
#define ORTHODRIVE_LANES 8
#define ORTHODRIVE_TILE_ROWS 6
#include "orthodrive/nets/layer_kernels.inl"
