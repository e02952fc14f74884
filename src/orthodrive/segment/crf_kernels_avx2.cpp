#define ORTHODRIVE_CRF_KERNELS avx2_crf_kernels
#include "orthodrive/segment/crf_kernels.inl"
