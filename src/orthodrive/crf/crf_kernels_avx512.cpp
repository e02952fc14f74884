// SPDX-License-Identifier: Apache-2.0
#define ORTHODRIVE_CRF_KERNELS avx512_crf_kernels
#include "orthodrive/crf/crf_kernels.inl"
