// SPDX-License-Identifier: MIT
//
// The emulated GPU has no OpenGL.
#include "raster/cuda/gl_target.cuh"

#include "raster/cuda/check.cuh"

namespace qs::cuda {

GlTarget::~GlTarget() = default;

void GlTarget::present(const float*, int, int, const GlBuffer&, cudaStream_t) {
  throw Error(ErrorKind::device, "cuda: CUDA-GL interop: the emulator has no OpenGL");
}

float GlTarget::present_ms() const { return 0; }

}  // namespace qs::cuda
