// SPDX-License-Identifier: MIT
// Scenes in the memory of a small GPU, which is counted in Gaussians here: opening, a second scene,
// and uploads that fail.
#include "app/viewer/render/upload_scene.h"

#include <gtest/gtest.h>

#include "base/error.h"
#include "support/pool.h"
#include "support/scenes.h"

namespace qs {
namespace {

struct SmallGpu {
  std::size_t used = 0, total = 0;
};

// Keeps the contract of Renderer: the old scene goes first, and returns if the new one fails.
class SmallRenderer : public Renderer {
 public:
  explicit SmallRenderer(SmallGpu& gpu) : gpu_(gpu) {}
  ~SmallRenderer() override { gpu_.used -= size_; }
  void upload(std::shared_ptr<const GaussianCloud> cloud, const Progress&) override {
    gpu_.used -= size_;
    size_ = 0;
    if (gpu_.used + cloud->size() > gpu_.total) throw Error(ErrorKind::device, "no memory");
    size_ = cloud->size();
    gpu_.used += size_;
    drawn = std::move(cloud);
    set = GaussianSet();
  }
  void set_drawn(GaussianSet of_drawn) override { set = std::move(of_drawn); }
  const Frame& render(const Camera&, const RenderSettings&, const Outputs&, const Target&,
                      std::stop_token) override {
    return frame_;
  }
  std::shared_ptr<const GaussianCloud> drawn;
  GaussianSet set;

 private:
  SmallGpu& gpu_;
  std::size_t size_ = 0;
  Frame frame_;
};

class Uploads : public testing::Test {
 protected:
  Uploads() {
    context_.session.pool = std::make_unique<ThreadPool>(1);
    gpu_.total = 1000;
    context_.make_renderer = [this](Backend backend, const Session&) {
      made_.push_back({backend, gpu_.used});
      return std::make_unique<SmallRenderer>(gpu_);
    };
    session().renderer = std::make_unique<SmallRenderer>(gpu_);
    show(600);
  }
  Session& session() { return context_.session; }
  SmallRenderer& renderer() { return dynamic_cast<SmallRenderer&>(*session().renderer); }
  static std::shared_ptr<const Scene> scene_of(std::size_t gaussians) {
    auto scene = std::make_shared<Scene>();
    scene->cloud = test::random_cloud(gaussians, 0, 1);
    return scene;
  }
  void show(std::size_t gaussians, Backend backend = Backend::cpu) {
    show_scene(context_, {scene_of(gaussians), {}, {}, backend}, {});
  }
  void set_beside(std::size_t gaussians) {
    auto beside = std::make_unique<SmallRenderer>(gpu_);
    const auto scene = scene_of(gaussians);
    beside->upload(cloud_of(scene), {});
    context_.beside = RenderedBeside{scene, {}, Backend::cpu, std::move(beside)};
  }

  // A renderer that was made, and the Gaussians in memory before.
  struct Made {
    Backend backend;
    std::size_t used;
    bool operator==(const Made&) const = default;
  };
  std::vector<Made> made_;
  SmallGpu gpu_;
  ActionQueue reports_{[] {}};
  RenderContext context_{reports_, {}};
};

TEST_F(Uploads, the_old_scene_goes_before_the_new_one_comes) {
  show(900);
  EXPECT_EQ(gpu_.used, 900u);
  EXPECT_EQ(session().scene->cloud.size(), 900u);
}

TEST_F(Uploads, a_scene_that_does_not_fit_leaves_the_old_one_drawn) {
  EXPECT_THROW(show(1001), Error);
  EXPECT_EQ(session().scene->cloud.size(), 600u);
  EXPECT_EQ(renderer().drawn->size(), 600u);
}

TEST_F(Uploads, the_old_scene_goes_before_the_new_one_comes_to_another_backend) {
  show(900, Backend::cuda);
  EXPECT_EQ(made_, (std::vector<Made>{{Backend::cuda, 0}}));
  EXPECT_EQ(gpu_.used, 900u);
  EXPECT_EQ(session().backend, Backend::cuda);
}

TEST_F(Uploads, the_second_scene_makes_room_on_another_backend) {
  set_beside(300);
  show(900, Backend::cuda);
  EXPECT_EQ(gpu_.used, 900u);
  EXPECT_EQ(context_.beside->renderer, nullptr);
}

TEST_F(Uploads, the_old_scene_returns_to_its_backend_if_the_new_one_does_not_fit_on_another) {
  EXPECT_THROW(show(1001, Backend::cuda), Error);
  EXPECT_EQ(made_, (std::vector<Made>{{Backend::cuda, 0}, {Backend::cpu, 0}}));
  EXPECT_EQ(session().backend, Backend::cpu);
  EXPECT_EQ(session().scene->cloud.size(), 600u);
  EXPECT_EQ(renderer().drawn->size(), 600u);
}

TEST_F(Uploads, an_edit_uploads_nothing_and_another_scene_is_whole) {
  gpu_.total = 2000;
  const auto drawn = renderer().drawn;
  GaussianSet gone(600);
  for (std::size_t i = 0; i < 200; ++i) gone.add(i);
  show_crop({.gone = std::make_shared<const GaussianSet>(gone), .steps = 2})(context_);
  EXPECT_EQ(renderer().drawn, drawn);
  EXPECT_EQ(renderer().set, gone.complement());
  EXPECT_EQ(session().scene->cloud.size(), 600u);
  EXPECT_EQ(drawn_count(session()), 400u);
  EXPECT_EQ(drawn_cloud(session())->size(), 400u);
  EXPECT_EQ(edits_of(session()).steps, 2);
  EXPECT_EQ(edits_of(session()).kept, 400u);
  // Another renderer of the scene draws the same.
  const auto second = upload_to(context_, session().scene, Backend::cpu, {});
  EXPECT_EQ(dynamic_cast<SmallRenderer&>(*second).set, gone.complement());
  show_crop({})(context_);
  EXPECT_EQ(renderer().set.size(), 0u);
  EXPECT_EQ(edits_of(session()), EditFacts());
  show_crop({.gone = std::make_shared<const GaussianSet>(gone), .steps = 2})(context_);
  show(300);
  EXPECT_FALSE(session().gone);
  EXPECT_EQ(drawn_count(session()), 300u);
}

TEST_F(Uploads, the_old_renderer_goes_before_another_backend_s_comes) {
  std::size_t used_before = 1;
  change_renderer(session(), Backend::cuda, [&](Backend) {
    used_before = gpu_.used;
    auto renderer = std::make_unique<SmallRenderer>(gpu_);
    renderer->upload(cloud_of(session().scene), {});
    return renderer;
  });
  EXPECT_EQ(used_before, 0u);
  EXPECT_EQ(gpu_.used, 600u);
  EXPECT_EQ(session().backend, Backend::cuda);
}

TEST_F(Uploads, the_old_renderer_comes_back_if_another_backend_fails_or_is_cancelled) {
  for (const bool cancelled : {false, true}) {
    std::vector<Backend> wanted;
    const auto upload = [&](Backend backend) -> std::unique_ptr<Renderer> {
      wanted.push_back(backend);
      if (backend == Backend::cuda && cancelled) throw Cancelled();
      auto renderer = std::make_unique<SmallRenderer>(gpu_);
      renderer->upload(backend == Backend::cuda
                           ? std::make_shared<GaussianCloud>(test::random_cloud(1001, 0, 1))
                           : cloud_of(session().scene),
                       {});
      return renderer;
    };
    if (cancelled) {
      EXPECT_THROW(change_renderer(session(), Backend::cuda, upload), Cancelled);
    } else {
      EXPECT_THROW(change_renderer(session(), Backend::cuda, upload), Error);
    }
    EXPECT_EQ(wanted, (std::vector<Backend>{Backend::cuda, Backend::cpu}));
    EXPECT_EQ(session().backend, Backend::cpu);
    ASSERT_NE(session().renderer, nullptr);
    EXPECT_EQ(renderer().drawn->size(), 600u);
    EXPECT_EQ(gpu_.used, 600u);
  }
}

TEST_F(Uploads, the_second_scene_makes_room_and_is_uploaded_again_later) {
  set_beside(300);
  show(800);
  EXPECT_EQ(session().scene->cloud.size(), 800u);
  ASSERT_TRUE(context_.beside) << "only its copy on the GPU goes";
  EXPECT_EQ(context_.beside->renderer, nullptr);
  EXPECT_EQ(context_.beside->scene->cloud.size(), 300u);
}

TEST_F(Uploads, a_second_scene_takes_the_place_of_the_one_before) {
  set_beside(300);
  show_beside(context_, scene_of(400), Backend::cpu, {});
  EXPECT_EQ(gpu_.used, 1000u);
  EXPECT_EQ(context_.beside->scene->cloud.size(), 400u);
  EXPECT_THROW(show_beside(context_, scene_of(401), Backend::cpu, {}), Error);
  EXPECT_EQ(context_.beside->scene->cloud.size(), 400u) << "the old one stays";
}

TEST_F(Uploads, a_second_scene_on_another_backend_comes_after_the_one_before_went) {
  set_beside(300);
  show_beside(context_, scene_of(400), Backend::cuda, {});
  EXPECT_EQ(made_, (std::vector<Made>{{Backend::cuda, 600}}));
  EXPECT_EQ(context_.beside->backend, Backend::cuda);
  EXPECT_THROW(show_beside(context_, scene_of(401), Backend::cpu, {}), Error);
  EXPECT_EQ(context_.beside->scene->cloud.size(), 400u) << "the old one stays";
  EXPECT_EQ(context_.beside->renderer, nullptr) << "and is uploaded again later";
}

}  // namespace
}  // namespace qs
