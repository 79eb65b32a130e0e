// SPDX-License-Identifier: MIT
//
// The numbers of charts, apart from their drawing. The recorder's chart has curves against the
// zoom, axes with round ticks, and the values at the cursor; the plots of `quadsplat zoom` have the
// same axes. The plot of the loss is against the iteration, both from 0, with round ticks.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <glm/vec2.hpp>

#include "app/report/zoom_bundle.h"
#include "app/viewer/state/training.h"
#include "app/viewer/state/zoom_recorder.h"

namespace qs {

/// Values in the unit of the quantity; low and high are the ends of the middle half of the frames.
struct ZoomPoint {
  double zoom = 1, value = 0, low = 0, high = 0;
  bool is_noisy = false;  ///< is_noisy_step()
};

struct ZoomCurve {
  CullMode mode = 0;
  bool is_beneath = false;        ///< of the recording that is drawn dashed
  bool has_bars = false;          ///< from low to high
  std::vector<ZoomPoint> points;  ///< by increasing zoom
};

inline constexpr const char* kZoomAxis = "zoom (first distance / distance)";

struct ZoomChart {
  std::string title;      ///< of the vertical axis, with its unit
  double most_zoom = 2;   ///< right end of the axis, which begins at 1
  double most_value = 1;  ///< top of the axis, which begins at 0
  std::vector<AxisTick> zoom_ticks, value_ticks;
  std::vector<ZoomCurve> curves;  ///< dashed ones first, so that the others are drawn over them

  bool empty() const { return curves.empty(); }
  /// The place of a point: fractions of the width from the left and of the height from the bottom.
  glm::dvec2 place(double zoom, double value) const;
};

/// Both may be null. Rows without a time have no point.
ZoomChart zoom_chart(const ZoomRecord* shown, const ZoomRecord* beneath, ZoomQuantity quantity);

/// The values at a measured zoom.
struct ZoomReading {
  struct Row {
    CullMode mode = 0;
    std::string value, beneath;  ///< empty without a point at this zoom
  };
  double zoom = 1;
  std::string title;  ///< "4.2x"
  std::vector<Row> rows;
};

/// The values at the measured zoom that is nearest to `x`, a fraction of the width. Empty without
/// points.
std::optional<ZoomReading> read_zoom_chart(const ZoomChart& chart, double x);

/// The loss has no unit: it is a mean over the pixels, of colours from 0 to 1.
inline constexpr const char* kLossTitle = "loss: 0.8 L1 + 0.2 (1 - SSIM), colours 0 to 1";
inline constexpr const char* kIterationTitle = "iteration";

/// Axes of a chart over the iterations of a training, with round ticks.
struct IterationChart {
  double most_iteration = 1, least = 0, most = 1;  ///< ends of the axes; iterations begin at 0
  std::vector<AxisTick> iteration_ticks, value_ticks;

  double share(double value) const { return (value - least) / (most - least); }  ///< of the height
};

/// The axis of losses begins at 0.
IterationChart loss_chart(const std::vector<LossPoint>& losses);

/// `points`: of all curves.
IterationChart psnr_chart(const std::vector<PsnrPoint>& points);

/// The loss whose iteration is nearest to `iteration`. `losses` must not be empty.
const LossPoint& loss_near(const std::vector<LossPoint>& losses, double iteration);

}  // namespace qs
