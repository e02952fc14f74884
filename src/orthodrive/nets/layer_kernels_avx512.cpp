// SPDX-License-Identifier: Apache-2.0
#define ORTHODRIVE_LAYER_KERNELS avx512_layer_kernels
#define ORTHODRIVE_LANES 16
#define ORTHODRIVE_TILE_ROWS 8
#include "orthodrive/nets/layer_kernels.inl"
