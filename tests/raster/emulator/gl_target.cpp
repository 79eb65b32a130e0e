// SPDX-License-Identifier: MIT
//
// The emulated GPU has no OpenGL.
#include "raster/cuda/gl_target.cuh"

#include "raster/cuda/check.cuh"

namespace qs::cuda {

GlTarget::Clockwork::~Clockwork() = default;
GlTarget::~GlTarget() = default;

void GlTarget::take(const GlTexture&) {
  throw Error(ErrorKind::device, "cuda: CUDA-GL interop: the emulator has no OpenGL");
}

void GlTarget::present(const float*, int, int, cudaStream_t) {}
void GlTarget::give_back() noexcept {}
float GlTarget::present_ms() const { return 0; }

}  // namespace qs::cuda
