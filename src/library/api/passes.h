// SPDX-License-Identifier: MIT
//
// The passes of the differentiable rasterizer on the device that holds the arrays of a call.
// Callers have checked the arguments.
#pragma once

#include <memory>

#include "library/check/context.h"
#include "library/check/frame_memory.h"
#include "library/check/stage_arguments.h"
#include "quadsplat/quadsplat.h"

namespace qs::library {

class Passes {
 public:
  virtual ~Passes() = default;

  /// Fills the wanted arrays, and the frame without its pixels.
  virtual void project(const CallersMemory& memory, const QsBoundary& boundary,
                       QsStageFrame& frame) = 0;
  /// Fills the pixels of the frame, and the wanted pictures.
  virtual void blend(const CallersMemory& memory, const QsBlended& pictures,
                     QsStageFrame& frame) = 0;
  virtual void blend_backward(const QsStageFrame& frame, const QsBlended& by,
                              const QsBoundaryGradients& out) = 0;
  virtual void project_backward(const QsStageFrame& frame, const QsBoundaryGradients& by,
                                const QsInputGradients& out) = 0;
  /// Both; the wanted arrays of `at_boundary` are written.
  virtual void backward(const QsStageFrame& frame, const QsBlended& by,
                        const QsBoundaryGradients& at_boundary, const QsInputGradients& out) = 0;
  /// Writes `counts`, see qs_count_pixels().
  virtual void count_pixels(const QsStageFrame& frame, double behind, const QsArray& counts) = 0;
  /// Multiplies the first two columns of `rows`, which may be absent, by x and y.
  virtual void scale(const QsArray& rows, double x, double y) = 0;

  /// The wanted arrays by normalised device coordinates in place of pixels.
  void to_ndc(const QsBoundaryGradients& out, const Camera& camera) {
    scale(out.means_px, camera.width / 2.0, camera.height / 2.0);
    scale(out.absolute_px, camera.width / 2.0, camera.height / 2.0);
  }
};

/// The call and the use of its context must outlive the result. Throw Error.
std::unique_ptr<Passes> cpu_passes(const StageCall& call, const Use& use);
std::unique_ptr<Passes> cuda_passes(const StageCall& call, const Use& use);

}  // namespace qs::library
