#define ORTHODRIVE_CRF_KERNELS avx512_crf_kernels
#include "orthodrive/segment/crf_kernels.inl"
