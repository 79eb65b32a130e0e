// SPDX-License-Identifier: MIT
//
// Carries out the steps of editing on a scene.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>

#include "base/progress.h"
#include "raster/api/renderer.h"
#include "raster/scene/gaussian_set.h"
#include "raster/select/edit_step.h"
#include "raster/select/shape.h"

namespace qs {

/// "crc32:89abcdef": the CRC-32 of the set's bytes.
using SetHash = std::function<std::string(const GaussianSet&)>;

/// The edited scene: hidden and removed Gaussians are never selected.
struct EditState {
  GaussianSet selected, hidden, removed;

  explicit EditState(std::size_t gaussians = 0)
      : selected(gaussians), hidden(gaussians), removed(gaussians) {}
  /// The Gaussians that are neither hidden nor removed.
  GaussianSet rest() const {
    GaussianSet gone = hidden;
    return (gone |= removed).complement();
  }
  bool operator==(const EditState&) const = default;
};

/// The Gaussians under a tool in the picture of the rest of a scene, by their indices in the whole
/// scene: a pixel in the shape blends them with at least the weight, see SeenPixels.
using SeenInPicture = std::function<GaussianSet(const GaussianSet& rest, const Camera& camera,
                                                const Shape& shape, float weight)>;

/// The drawn Gaussians under a tool. The renderer has the cloud.
GaussianSet seen_by(Renderer& renderer, const GaussianCloud& cloud, const Camera& camera,
                    const Shape& shape, float weight, ThreadPool& pool, std::stop_token stop);

/// Lets the renderer draw the rest; `has_cloud`: it has the cloud, else it is uploaded first.
SeenInPicture seen_with(Renderer& renderer, std::shared_ptr<const GaussianCloud> cloud,
                        ThreadPool& pool, bool has_cloud = false, std::stop_token stop = {});

struct EditTools {
  const GaussianCloud& cloud;
  ThreadPool& pool;
  SeenInPicture seen;
  SetHash hash;
  Progress progress = {};
  /// Uses the tools of steps that have a list of members, too.
  bool recomputes = false;
};

/// The shape of a tool that draws in a picture.
Shape shape_of(const SelectStep& step);

/// Carries out one step on the state. `where` names it in messages. If the step has a count, a hash
/// or a list that does not belong to this scene, throws Error(input). With EditTools::recomputes a
/// difference gives a sentence in place of an error, and the computed selection stays; else "" is
/// returned.
std::string carry_out(const EditStep& step, const EditTools& tools, const std::string& where,
                      EditState& state);

/// Sets count, hash and, for visible and touching Gaussians, the list of a select step that was
/// carried out.
void note_result(const EditState& state, const SetHash& hash, SelectStep& step);

}  // namespace qs
