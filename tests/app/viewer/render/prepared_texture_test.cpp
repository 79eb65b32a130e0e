// SPDX-License-Identifier: MIT
// The texture of the next frame, on a GPU that fails.
#include <set>
#include <variant>

#include <gtest/gtest.h>

#include "app/viewer/render/gl_frames.h"
#include "base/error.h"

namespace qs {
namespace {

class Textures {
 public:
  GlTexture take(int, int) {
    taken.insert(++last_);
    return {last_, 1};
  }
  void give_back(const GlTexture& texture) { taken.erase(texture.name); }
  std::set<unsigned> taken;

 private:
  unsigned last_ = 0;
};

class FailingRenderer : public Renderer {
 public:
  void upload(std::shared_ptr<const GaussianCloud>, const Progress&) override {}
  const Frame& render(const Camera&, const RenderSettings&, const Outputs&, const Target&,
                      std::stop_token) override {
    return frame_;
  }
  void prepare_target(const Target& target) override {
    if (fails) throw Error(ErrorKind::device, "the GPU fails");
    prepared = target;
  }
  bool fails = false;
  Target prepared;

 private:
  Frame frame_;
};

TEST(PreparedTexture, is_the_next_frame_s_if_the_size_fits) {
  Textures textures;
  FailingRenderer renderer;
  PreparedTexture<Textures> next;
  next.prepare(8, 6, textures, renderer);
  EXPECT_EQ(std::get<GlTexture>(renderer.prepared), (GlTexture{1, 1}));
  EXPECT_EQ(next.take(8, 6, textures, renderer).name, 1u);
  EXPECT_EQ(next.take(8, 6, textures, renderer).name, 2u);
  next.prepare(8, 6, textures, renderer);
  EXPECT_EQ(next.take(4, 3, textures, renderer).name, 4u);
  EXPECT_EQ(textures.taken, (std::set<unsigned>{1, 2, 4})) << "the prepared one was given back";
  EXPECT_TRUE(std::holds_alternative<HostImage>(renderer.prepared));
}

// GlFrames has five textures, so a loss per failure ends the program at the sixth.
TEST(PreparedTexture, of_a_gpu_that_fails_is_never_lost) {
  Textures textures;
  FailingRenderer renderer;
  PreparedTexture<Textures> next;
  next.prepare(8, 6, textures, renderer);
  for (int frame = 0; frame < 6; ++frame) {
    renderer.fails = true;
    EXPECT_THROW(next.take(4, 3, textures, renderer), Error);
    EXPECT_EQ(textures.taken.size(), 1u);
    renderer.fails = false;
    textures.give_back(next.take(4, 3, textures, renderer));
    EXPECT_EQ(textures.taken.size(), 0u);
    renderer.fails = true;
    EXPECT_THROW(next.prepare(8, 6, textures, renderer), Error);
    EXPECT_EQ(textures.taken.size(), 1u) << "kept for the next frame";
  }
}

}  // namespace
}  // namespace qs
