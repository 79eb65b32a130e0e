// SPDX-License-Identifier: MIT
//
// GlTarget for the emulated GPU, which has no OpenGL.
#include "raster/cuda/common/gl_target.cuh"

#include "raster/cuda/common/check.cuh"

namespace qs::cuda {

GlTarget::~GlTarget() = default;

void GlTarget::map(const GlTexture&) {
  throw Error(ErrorKind::device, "cuda: CUDA-GL interop: the emulator has no OpenGL");
}

void GlTarget::present(const float*, int, int, cudaStream_t) {}
void GlTarget::unmap() noexcept {}
float GlTarget::present_ms() const { return 0; }

}  // namespace qs::cuda
