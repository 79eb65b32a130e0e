// SPDX-License-Identifier: MIT
#include "app/session/exact_color.h"

#include <span>
#include <utility>
#include <vector>

#include <glm/matrix.hpp>

#include "io/cloud/axes.h"
#include "raster/field/field_evaluator.h"

namespace qs {
namespace {

// The network's colours from any position.
class NetworkView {
 public:
  // The network knows the axes of its file.
  NetworkView(const NetworkColors& network, const std::string& axes, ThreadPool& pool)
      : evaluator_(*network.field), file_from_world_(glm::transpose(rdf_from(axes))), pool_(pool) {}

  // The colours become spherical harmonics of degree 0, whose coefficients are the network's
  // outputs.
  GaussianCloud from(const glm::dvec3& eye, const GaussianCloud& cloud) const {
    GaussianCloud seen;
    seen.positions = cloud.positions;
    seen.log_scales = cloud.log_scales;
    seen.rotations = cloud.rotations;
    seen.opacity_logits = cloud.opacity_logits;
    seen.antialiased = cloud.antialiased;
    seen.origin = cloud.origin;
    seen.sh.resize(cloud.size());
    const glm::vec3 file_eye(file_from_world_ * eye);
    constexpr std::size_t kGrain = 1024;
    pool_.for_chunks(cloud.size(), kGrain, [&](std::size_t begin, std::size_t end, int) {
      std::vector<glm::vec3> means(cloud.positions.begin() + static_cast<std::ptrdiff_t>(begin),
                                   cloud.positions.begin() + static_cast<std::ptrdiff_t>(end));
      // A turn by right angles is exact, so means are as in the file.
      for (glm::vec3& mean : means) mean = glm::vec3(file_from_world_ * glm::dvec3(mean));
      evaluator_.outputs(means, file_eye, std::span(seen.sh).subspan(begin, end - begin));
    });
    return seen;
  }

 private:
  FieldEvaluator evaluator_;
  glm::dmat3 file_from_world_;
  ThreadPool& pool_;
};

class ExactColorRenderer : public Renderer {
 public:
  ExactColorRenderer(std::unique_ptr<Renderer> inner, const NetworkColors& network,
                     const std::string& axes, ThreadPool& pool)
      : inner_(std::move(inner)), view_(network, axes, pool) {}

  void upload(std::shared_ptr<const GaussianCloud> cloud, const Progress& progress) override {
    progress.update(0);
    cloud_ = std::move(cloud);
    eye_.reset();
    drawn_ = GaussianSet();
    progress.update(1);
  }

  void set_drawn(GaussianSet drawn) override {
    if (eye_) inner_->set_drawn(drawn);
    drawn_ = std::move(drawn);
  }

  const Frame& render(const Camera& camera, const RenderSettings& settings, const Outputs& outputs,
                      const Target& target, std::stop_token stop) override {
    if (eye_ != camera.position()) {
      eye_.reset();
      Progress progress;
      progress.stop = stop;
      inner_->upload(view_.from(camera.position(), *cloud_), progress);
      if (drawn_.size() > 0) inner_->set_drawn(drawn_);
      eye_ = camera.position();
    }
    return inner_->render(camera, settings, outputs, target, stop);
  }

  void prepare_target(const Target& target) override { inner_->prepare_target(target); }

  void report_frames_to(std::function<void(float fraction)> report) override {
    inner_->report_frames_to(std::move(report));
  }

 private:
  std::unique_ptr<Renderer> inner_;
  NetworkView view_;
  std::shared_ptr<const GaussianCloud> cloud_;
  GaussianSet drawn_;
  std::optional<glm::dvec3> eye_;  // the eye for which `inner_` has the colours
};

}  // namespace

std::unique_ptr<Renderer> with_exact_color(std::unique_ptr<Renderer> inner,
                                           const NetworkColors& network, const std::string& axes,
                                           ThreadPool& pool) {
  return std::make_unique<ExactColorRenderer>(std::move(inner), network, axes, pool);
}

GaussianCloud seen_from(const glm::dvec3& eye, const GaussianCloud& cloud,
                        const NetworkColors& network, const std::string& axes, ThreadPool& pool) {
  return NetworkView(network, axes, pool).from(eye, cloud);
}

}  // namespace qs
