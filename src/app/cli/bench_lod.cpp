// SPDX-License-Identifier: MIT
#include "app/cli/bench_lod.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <string>
#include <tuple>

#include <fmt/format.h>

#include "app/inspect/picture_pair.h"
#include "app/measure/lod_levels.h"
#include "app/measure/scene_facts.h"
#include "app/measure/statistics.h"
#include "app/session/alterations.h"
#include "base/fail.h"
#include "base/progress_bar.h"
#include "base/text.h"
#include "io/bytes/replace_file.h"
#include "raster/scene/cloud_order.h"
#include "raster/scene/image_metrics.h"
#include "raster/scene/place.h"

namespace qs {
namespace {

struct Distance {
  const char* name;
  double factor;  // on the median depth of the picture's centre
};
constexpr Distance kDistances[] = {{"near", 1}, {"middle", 4}, {"far", 16}};

/// The Gaussians of which a budget is a share, and the views of a cut.
enum class LodShare {
  all,     ///< of all leaves; one cut for all views of a distance
  in_view  ///< of the leaves that the view shows; a cut for each view
};
constexpr const char* kShareNames[] = {"all", "in view"};

// A picture of a level.
struct LodRow {
  std::string distance, method;
  LodShare share = LodShare::all;
  double budget = 0;  // per cent
  std::size_t gaussians = 0;
  PictureQuality quality;
  double worst_block = 0, ms = 0;  // dB
};

// A tree and its rule of errors.
struct TreeMethod {
  std::string name;
  const NodeTree* tree;
  bool by_distance;
};

struct LodView {
  Shot shot;
  Camera camera;
  Image truth;
  std::vector<std::uint32_t> leaves;                     // that the view shows
  std::map<const NodeTree*, std::vector<bool>> shown{};  // nodes of each tree
};

// The median of the positive values, of the picture's centre if it has any.
double median_depth(const std::vector<float>& depths, const Camera& camera) {
  const auto positive = [&](double left, double top) {
    std::vector<double> values;
    for (int y = static_cast<int>(top * camera.height); y < (1 - top) * camera.height; ++y)
      for (int x = static_cast<int>(left * camera.width); x < (1 - left) * camera.width; ++x)
        if (const float depth = depths[static_cast<std::size_t>(y * camera.width + x)]; depth > 0)
          values.push_back(static_cast<double>(depth));
    return values;
  };
  std::vector<double> values = positive(1.0 / 3, 1.0 / 3);
  if (values.empty()) values = positive(0, 0);
  return values.empty() ? 0 : median(values);
}

// `altered`: alterations of the scene in words, or empty.
std::string lod_csv(const std::string& scene, const std::string& altered,
                    const std::vector<LodRow>& rows) {
  std::string text =
      "scene,camera,distance,share_of,budget_percent,method,gaussians,width,height,psnr,ssim,flip,"
      "worst_block_psnr,ms";
  text += altered.empty() ? "\n" : ",altered\n";
  for (const LodRow& row : rows) {
    text += fmt::format("{},{},{},{},{:.4g},{},{},{},{},{:.4f},{:.6f},{:.6f},{:.4f},{:.3f}",
                        csv_field(scene), csv_field(row.quality.view), row.distance,
                        kShareNames[static_cast<int>(row.share)], row.budget, csv_field(row.method),
                        row.gaussians, row.quality.width, row.quality.height, row.quality.psnr,
                        row.quality.ssim, row.quality.flip, row.worst_block, row.ms);
    text += altered.empty() ? "\n" : "," + csv_field(altered) + "\n";
  }
  return text;
}

// Cells of the means over the views: Gaussians, PSNR, SSIM, FLIP, the worst block of all, ms.
std::string mean_cells(const std::vector<const LodRow*>& rows) {
  if (rows.empty()) return " - | - | - | - | - | - |";
  std::vector<PictureQuality> qualities;
  double worst = std::numeric_limits<double>::infinity(), gaussians = 0, ms = 0;
  const auto views = static_cast<double>(rows.size());
  for (const LodRow* row : rows) {
    qualities.push_back(row->quality);
    worst = std::min(worst, row->worst_block);
    gaussians += static_cast<double>(row->gaussians) / views;
    ms += row->ms / views;
  }
  const PictureQuality mean = mean_quality(qualities);
  return fmt::format(" {} | {} | {:.4f} | {:.4f} | {} | {:.1f} |",
                     grouped(static_cast<std::uint64_t>(std::llround(gaussians))),
                     decibels(mean.psnr), mean.ssim, mean.flip, decibels(worst), ms);
}

std::string lod_table(const std::vector<LodRow>& rows) {
  std::string text =
      "| distance | budget | method | Gaussians | PSNR dB | SSIM | FLIP | worst block dB | ms | in "
      "view: Gaussians | PSNR dB | SSIM | FLIP | worst block dB | ms |\n"
      "|---|---:|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|\n";
  using Key = std::tuple<std::string, double, std::string>;
  std::vector<Key> keys;
  for (const LodRow& row : rows)
    if (const Key key(row.distance, row.budget, row.method); std::ranges::count(keys, key) == 0)
      keys.push_back(key);
  const auto order = [](const Key& key) {
    const auto* const distance = std::ranges::find(kDistances, std::get<0>(key), &Distance::name);
    return std::pair(distance - kDistances, std::get<1>(key));
  };
  std::ranges::stable_sort(keys, {}, order);
  for (const Key& key : keys) {
    text += fmt::format("| {} | {:.3g} % | {} |", std::get<0>(key), std::get<1>(key),
                        markdown_text(std::get<2>(key)));
    for (const LodShare share : {LodShare::all, LodShare::in_view}) {
      std::vector<const LodRow*> cell;
      for (const LodRow& row : rows)
        if (row.share == share && Key(row.distance, row.budget, row.method) == key)
          cell.push_back(&row);
      text += mean_cells(cell);
    }
    text += '\n';
  }
  return text;
}

class LodRun {
 public:
  explicit LodRun(const LodBench& bench) : bench_(bench), session_(open_session(bench.frame)) {
    if (session_.scene->network)
      fail(ErrorKind::usage, "bench: --lod: {}: its colours are a network's",
           session_.scene->path.string());
    for (const std::filesystem::path& other : bench.others) open_other(other);
    if (session_.scene->levels) open_tree(session_.scene->path, false);
    std::vector<Shot> shots = choose_shots_or_all(bench.cameras, bench.frame, session_);
    for (Shot& shot : shots) views_.push_back({shot, shot.camera, {}, {}});
    ProgressBar bar("octree");
    bar.progress().update(0);
    octree_ = octree_of(leaves(), *session_.pool);
    methods_.insert(methods_.begin(), {{"octree", &octree_, false}, {"distance", &octree_, true}});
  }

  void run() {
    find_depths();
    for (const Distance& distance : kDistances) {
      bar_.relabel(fmt::format("levels: {}", distance.name));
      one_distance(distance);
    }
    bar_.hide();
    const std::string name = scene_name(session_.scene->path);
    const std::string text =
        fmt::format("# Levels of detail: {}, {}, {}, backend {}{}\n\n{}", markdown_text(name),
                    counted(leaves().size(), "Gaussian"), counted(views_.size(), "view"),
                    kBackendNames[static_cast<int>(session_.backend)], altered_clause(session_),
                    lod_table(rows_));
    fmt::print("{}", text);
    if (!bench_.out_dir) return;
    replace_folder(*bench_.out_dir, [&](const std::filesystem::path& hidden) {
      write_text(hidden / "lod.csv", lod_csv(name, alterations_of(session_).text, rows_));
      write_text(hidden / "lod.md", "<!-- written by quadsplat bench -->\n" + text);
    });
    fmt::print(stderr, "wrote {}\n", bench_.out_dir->string());
  }

 private:
  struct Level {
    std::string name;
    std::shared_ptr<const GaussianCloud> cloud;
  };

  const GaussianCloud& leaves() const { return session_.scene->cloud; }

  static std::string view_name(const LodView& view) {
    return view.shot.number < 0 ? view.shot.origin : fmt::format("{}", view.shot.number);
  }

  // Each file is a column of its own.
  std::string method_name(const std::filesystem::path& path) const {
    const std::string name = path.filename().string();
    const auto is_taken = [&](const auto& methods) {
      return std::ranges::any_of(methods, [&](const auto& each) { return each.name == name; });
    };
    return is_taken(methods_) || is_taken(levels_) ? path.string() : name;
  }

  void open_other(const std::filesystem::path& path) {
    Scene scene = load_scene(path, *session_.pool, -1, bench_.frame.axes);
    if (scene.levels && open_tree(path, true)) return;
    place(scene.cloud, leaves().origin);
    levels_.push_back(
        {method_name(path), std::make_shared<const GaussianCloud>(std::move(scene.cloud))});
  }

  // True if the file has a tree of which all nodes can be read.
  bool open_tree(const std::filesystem::path& path, bool warns) {
    ReadOptions options;
    options.axes = bench_.frame.axes;
    options.keeps_nodes = true;
    Scene scene = read_scene(path, *session_.pool, options);
    if (scene.parents.empty()) return false;
    place(scene.cloud, leaves().origin);
    if (warns && scene.levels->leaves != leaves().size())
      warn(fmt::format("{}: it has {} leaves, and the scene {}", path.string(),
                       grouped(scene.levels->leaves), grouped(leaves().size())));
    trees_.push_back(std::make_unique<const NodeTree>(
        std::make_shared<const GaussianCloud>(std::move(scene.cloud)), std::move(scene.parents)));
    methods_.push_back({method_name(path), trees_.back().get(), true});
    return true;
  }

  void find_depths() {
    for (LodView& view : views_) {
      Outputs outputs;
      outputs.color = false;
      outputs.depth = true;
      const Frame& frame = session_.renderer->render(view.camera, session_.settings, outputs);
      depths_.push_back(median_depth(frame.depth.median, view.camera));
      if (depths_.back() == 0)
        fail(ErrorKind::usage, "bench: --lod: {}: nothing in its picture has a depth",
             view.shot.origin);
    }
  }

  void one_distance(const Distance& distance) {
    for (std::size_t i = 0; i < views_.size(); ++i) {
      views_[i].camera = views_[i].shot.camera;
      views_[i].camera.view_from_world[3].z += depths_[i] * (distance.factor - 1);
    }
    look_at_leaves();
    for (const TreeMethod& method : methods_) look_at_nodes(*method.tree);
    distance_ = distance.name;
    for (const double budget : bench_.budgets) {
      budget_ = budget;
      measure_one_cut();
      measure_cuts_of_views();
    }
    for (const Level& level : levels_) {
      budget_ =
          100 * static_cast<double>(level.cloud->size()) / static_cast<double>(leaves().size());
      draw_level(level.name, LodShare::all, level.cloud, views_);
    }
  }

  std::size_t share_of(std::size_t count) const {
    return std::clamp<std::size_t>(
        static_cast<std::size_t>(std::llround(static_cast<double>(count) * budget_ / 100)), 1,
        count);
  }

  void look_at_leaves() {
    session_.renderer->upload(cloud_of(session_.scene), {});
    for (LodView& view : views_) {
      Outputs outputs;
      outputs.trace = true;
      const Frame& frame = session_.renderer->render(view.camera, session_.settings, outputs);
      view.truth = frame.color;
      view.leaves = frame.trace.gaussians;
      view.shown.clear();
    }
  }

  void look_at_nodes(const NodeTree& tree) {
    if (views_[0].shown.contains(&tree)) return;
    session_.renderer->upload(tree.nodes, {});
    for (LodView& view : views_) {
      Outputs outputs;
      outputs.color = false;
      outputs.trace = true;
      std::vector<bool>& shown = view.shown[&tree];
      shown.assign(tree.parents.size(), false);
      const Frame& frame = session_.renderer->render(view.camera, session_.settings, outputs);
      for (const std::uint32_t node : frame.trace.gaussians) shown[node] = true;
    }
  }

  std::vector<double> errors_of(const TreeMethod& method, std::span<const Camera> cameras) const {
    return method.by_distance ? pixel_sizes(*method.tree, cameras) : method.tree->order;
  }

  void measure_one_cut() {
    const std::size_t budget = share_of(leaves().size());
    draw_level("uniform", LodShare::all,
               std::make_shared<const GaussianCloud>(uniform_sample(leaves(), budget)), views_);
    std::vector<Camera> cameras;
    for (const LodView& view : views_) cameras.push_back(view.camera);
    for (const TreeMethod& method : methods_)
      draw_level(method.name, LodShare::all,
                 drawn(method, cut_of(*method.tree, errors_of(method, cameras), budget)), views_);
  }

  void measure_cuts_of_views() {
    for (LodView& view : views_) {
      if (view.leaves.empty()) continue;  // nothing is left out
      const std::size_t budget = share_of(view.leaves.size());
      const std::span one(&view, 1);
      draw_level("uniform", LodShare::in_view,
                 std::make_shared<const GaussianCloud>(
                     uniform_sample(select(leaves(), view.leaves), budget)),
                 one);
      for (const TreeMethod& method : methods_)
        draw_level(method.name, LodShare::in_view,
                   drawn(method, cut_of(*method.tree, errors_of(method, {&view.camera, 1}), budget,
                                        view.shown[method.tree])),
                   one);
    }
  }

  static std::shared_ptr<const GaussianCloud> drawn(const TreeMethod& method,
                                                    const std::vector<std::uint32_t>& cut) {
    return std::make_shared<const GaussianCloud>(select(*method.tree->nodes, cut));
  }

  void draw_level(const std::string& method, LodShare share,
                  const std::shared_ptr<const GaussianCloud>& cloud, std::span<LodView> views) {
    if (!cloud->empty()) session_.renderer->upload(cloud, {});
    for (LodView& view : views) {
      LodRow row{distance_, method, share, budget_, cloud->size(), {}, 0, 0};
      Image image(view.truth.width, view.truth.height, view.truth.channels);
      for (std::size_t i = 0; i < image.values.size(); ++i)
        image.values[i] = session_.settings.background[static_cast<int>(i % 3)];
      std::vector<double> times;
      for (int i = -bench_.warmup; i < bench_.frames && !cloud->empty(); ++i) {
        const Frame& frame = session_.renderer->render(view.camera, session_.settings);
        if (i >= 0) times.push_back(static_cast<double>(frame.stats.frame_ms));
        if (i == bench_.frames - 1) image = frame.color;
      }
      if (!times.empty()) row.ms = median(times);
      const PicturePair pair =
          judge_pictures(view_name(view), view.truth, std::move(image), *session_.pool);
      row.quality = pair.quality;
      row.worst_block = worst_block_psnr(pair.truth, pair.judged);
      rows_.push_back(std::move(row));
      progress_.update(static_cast<float>(rows_.size()) / static_cast<float>(pictures()));
    }
  }

  // Pictures of the whole run.
  std::size_t pictures() const {
    return std::size(kDistances) * views_.size() *
           (bench_.budgets.size() * 2 * (1 + methods_.size()) + levels_.size());
  }

  const LodBench& bench_;
  Session session_;
  NodeTree octree_;
  std::vector<std::unique_ptr<const NodeTree>> trees_;
  std::vector<TreeMethod> methods_;
  std::vector<Level> levels_;
  std::vector<LodView> views_;
  std::vector<double> depths_;  // of the views
  std::vector<LodRow> rows_;
  std::string distance_;  // of the pictures that are drawn
  double budget_ = 0;
  ProgressBar bar_{"levels"};
  Progress progress_ = bar_.progress();
};

}  // namespace

void run_lod_bench(const LodBench& bench) { LodRun(bench).run(); }

}  // namespace qs
