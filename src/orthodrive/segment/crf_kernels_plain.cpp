#define ORTHODRIVE_CRF_KERNELS plain_crf_kernels
#include "orthodrive/segment/crf_kernels.inl"
