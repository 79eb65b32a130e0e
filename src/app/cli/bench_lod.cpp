// SPDX-License-Identifier: MIT
#include "app/cli/bench_lod.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <string>
#include <tuple>

#include <fmt/format.h>

#include "app/inspect/picture_pair.h"
#include "app/measure/lod_levels.h"
#include "app/measure/scene_facts.h"
#include "app/measure/statistics.h"
#include "app/picture/palette.h"
#include "app/report/plot.h"
#include "app/session/alterations.h"
#include "app/session/surfaces.h"
#include "base/fail.h"
#include "base/progress_bar.h"
#include "base/text.h"
#include "base/warn.h"
#include "io/bytes/replace_file.h"
#include "io/scene/reader.h"
#include "learn/lod/cut.h"
#include "learn/lod/error_cloud.h"
#include "raster/pages/page_stream.h"
#include "raster/scene/cloud_order.h"
#include "raster/scene/image_metrics.h"
#include "raster/scene/place.h"

namespace qs {
namespace {

const std::string kCsvHeader =
    "scene,camera,distance,share_of,budget_percent,method,gaussians,width,height,psnr,ssim,flip,"
    "worst_block_psnr,ms,error_rank_correlation,error_ratio";

struct Distance {
  const char* name;
  double factor;  // on the median depth of the picture's centre
};
constexpr std::array<Distance, 3> kDistances = {{{"near", 1}, {"middle", 4}, {"far", 16}}};

// A node outside of a picture gains this share of its gain at its distance (docs/lod.md).
constexpr float kOutside = 1e-4f;

enum class LodRule { errors, distance, order };

// A uniform sample, or the cuts of a tree by one rule, or a level that another tool made.
struct LodMethod {
  std::string name;
  std::shared_ptr<const LodPages> tree = {};
  LodRule rule = LodRule::order;
  std::shared_ptr<const GaussianCloud> level = {};
};

// A cut as it is drawn, or a level.
struct LodLevel {
  std::shared_ptr<const GaussianCloud> drawn;
  LodCut cut = {};
};

struct LodShot {
  Shot shot;
  double depth = 0;    // median in the picture's centre
  Camera camera = {};  // of the current distance
  Image truth = {};
  std::vector<std::uint32_t> leaves = {};  // that it shows
  // Of each tree: true if the view shows the node.
  std::map<std::shared_ptr<const LodPages>, std::vector<bool>> nodes = {};
};

// The pictures of a cell of the table.
struct LodCell {
  std::vector<PictureQuality> views;
  double worst_block = std::numeric_limits<double>::infinity();  // dB
  double gaussians = 0, ms = 0;                                  // sums
  std::vector<double> correlations;                              // of estimated and measured errors

  std::string text() const {
    if (views.empty()) return " - | - | - | - | - | - | - |";
    const PictureQuality mean = mean_quality(views);
    const auto count = static_cast<double>(views.size());
    return fmt::format(
        " {} | {} | {:.4f} | {:.4f} | {} | {} | {:.1f} |",
        grouped(static_cast<std::uint64_t>(std::llround(gaussians / count))), decibels(mean.psnr),
        mean.ssim, mean.flip, decibels(worst_block),
        correlations.empty() ? "-" : fmt::format("{:.2f}", summarise(correlations).mean),
        ms / count);
  }
};

// The median of the positive values in the picture's centre; 0 if it has none.
double median_depth(const std::vector<float>& depths, const Camera& camera) {
  std::vector<double> values;
  for (int y = camera.height / 3; y < 2 * camera.height / 3; ++y)
    for (int x = camera.width / 3; x < 2 * camera.width / 3; ++x)
      if (const float depth = depths[static_cast<std::size_t>(y * camera.width + x)]; depth > 0)
        values.push_back(static_cast<double>(depth));
  return values.empty() ? 0 : median(values);
}

class LodRun {
 public:
  explicit LodRun(const LodBench& bench)
      : bench_(bench),
        session_(open_session(bench.frame)),
        octree_(octree_of(session_.scene->cloud, *session_.pool)),
        methods_{{"uniform"}} {
    const auto tree = std::make_shared<const LodPages>(octree_.tree);
    methods_.push_back({"octree", tree, LodRule::order});
    methods_.push_back({"distance", tree, LodRule::distance});
    if (session_.scene->levels) open(session_.scene->path, true);
    for (const std::filesystem::path& other : bench.others) open(other, false);
    for (const Shot& shot : choose_shots_or_all(bench.cameras, bench.frame, session_))
      views_.push_back({shot});
  }

  void run() {
    find_depths();
    for (std::size_t i = 0; i < kDistances.size(); ++i) {
      distance_ = i;
      progress_ = step_of(bar_.progress(), i, kDistances.size());
      one_distance();
    }
    bar_.hide();
    const std::string text = fmt::format(
        "# Levels of detail: {}, {}, {}, backend {}{}\n\n{}", markdown_text(scene_),
        counted(leaves().size(), "Gaussian"), counted(views_.size(), "view"),
        kBackendNames[static_cast<int>(session_.backend)], altered_clause(session_), table());
    fmt::print("{}", text);
    if (!bench_.out_dir) return;
    replace_folder(*bench_.out_dir, [&](const std::filesystem::path& hidden) {
      write_text(hidden / "lod.csv", kCsvHeader + (altered_.empty() ? "\n" : ",altered\n") + csv_);
      write_text(hidden / "lod.md", "<!-- written by quadsplat bench -->\n" + text);
      if (const std::string problem = draw_plots(hidden, error_plots(), *bench_.out_dir);
          !problem.empty())
        warn(problem);
    });
    fmt::print(stderr, "wrote {}\n", bench_.out_dir->string());
  }

 private:
  // Distance, budget, method; and the pictures for shares of all leaves, and of the leaves in view.
  using Key = std::tuple<std::size_t, double, std::size_t>;

  const GaussianCloud& leaves() const { return session_.scene->cloud; }

  // A file is a level, unless all nodes of its tree can be read. `is_scene`: its warnings were
  // printed.
  void open(const std::filesystem::path& path, bool is_scene) {
    ReadOptions options;
    options.axes = bench_.frame.axes;
    if (path.extension() == ".rad") options.streams = StreamedTrees::all;
    Scene scene = read_scene(path, *session_.pool, options);
    if (is_scene && !scene.stream) return;
    for (const std::string& warning : scene.warnings)
      if (!is_scene) warn("warning: " + warning);
    if (!scene.stream) {
      place(scene.cloud, leaves().origin);
      const auto cloud = std::make_shared<const GaussianCloud>(std::move(scene.cloud));
      return methods_.push_back({path.string(), {}, LodRule::order, cloud});
    }
    const auto tree = std::make_shared<const LodPages>(scene.stream->whole_tree(*session_.pool));
    std::size_t count = 0;  // of leaves
    for (const auto& page : tree->pages)
      count += static_cast<std::size_t>(std::ranges::count(page->nodes, 0, &LodFacts::child_count));
    if (!is_scene && count != leaves().size())
      warn(fmt::format("{}: it has {} leaves, and the scene {}", path.string(), grouped(count),
                       grouped(leaves().size())));
    if (tree->footprint > 0)
      methods_.push_back({path.string() + " by its errors", tree, LodRule::errors});
    methods_.push_back({path.string(), tree, LodRule::distance});
  }

  void find_depths() {
    Outputs outputs;
    outputs.color = false;
    outputs.depth = true;
    for (LodShot& view : views_) {
      const Frame& frame = session_.renderer->render(view.shot.camera, session_.settings, outputs);
      view.depth = median_depth(frame.depth.median, view.shot.camera);
      if (view.depth == 0)
        fail(ErrorKind::usage, "bench: --lod: {}: the middle of its picture has no depth",
             view.shot.origin);
    }
  }

  void one_distance() {
    for (LodShot& view : views_) {
      view.camera = view.shot.camera;
      view.camera.view_from_world[3].z += view.depth * (kDistances[distance_].factor - 1);
    }
    look();
    for (std::size_t i = 0; i < methods_.size(); ++i) {
      progress_.update(static_cast<float>(i) / static_cast<float>(methods_.size()));
      const LodMethod& method = methods_[i];
      if (method.level) {
        const auto size = static_cast<double>(method.level->size());
        const Key key{distance_, 100 * size / static_cast<double>(leaves().size()), i};
        draw(key, false, std::vector<LodLevel>(views_.size(), {method.level}), views_);
        continue;
      }
      for (const double budget : bench_.budgets) {
        const Key key{distance_, budget, i};
        draw(key, false, levels_of(method, budget, views_, false), views_);
        for (const LodShot& view : views_)
          if (!view.leaves.empty())  // else no level differs
            draw(key, true, levels_of(method, budget, {&view, 1}, true), {&view, 1});
      }
    }
  }

  // Draws the true pictures, and finds the leaves and nodes that each view shows.
  void look() {
    Outputs outputs;
    outputs.trace = true;
    session_.renderer->upload(cloud_of(session_.scene), {});
    for (LodShot& view : views_) {
      const Frame& frame = session_.renderer->render(view.camera, session_.settings, outputs);
      view.truth = frame.color;
      view.leaves = frame.trace.gaussians;
      view.nodes.clear();
    }
    outputs.color = false;
    for (const LodMethod& method : methods_) {
      if (!method.tree || views_[0].nodes.contains(method.tree)) continue;
      session_.renderer->upload(all_nodes(*method.tree), {});
      for (LodShot& view : views_) {
        std::vector<bool>& nodes = view.nodes[method.tree];
        nodes.resize(method.tree->count);
        const Frame& frame =
            session_.renderer->render(camera_of(method, view), session_.settings, outputs);
        for (const std::uint32_t node : frame.trace.gaussians) nodes[node] = true;
      }
    }
  }

  static Camera camera_of(const LodMethod& method, const LodShot& view) {
    return method.tree ? view.camera.placed(method.tree->pages[0]->cloud.origin) : view.camera;
  }

  // One cut for these views, as each draws it. `in_view`: the budget is a share of the leaves that
  // the only view shows; else of all leaves.
  std::vector<LodLevel> levels_of(const LodMethod& method, double budget,
                                  std::span<const LodShot> shots, bool in_view) {
    const std::size_t all = in_view ? shots[0].leaves.size() : leaves().size();
    const auto share =
        static_cast<std::size_t>(std::llround(static_cast<double>(all) * budget / 100));
    const std::size_t count = std::clamp<std::size_t>(share, 1, all);
    if (!method.tree)
      return {shots.size(),
              {std::make_shared<const GaussianCloud>(
                  uniform_sample(in_view ? select(leaves(), shots[0].leaves) : leaves(), count))}};
    const LodPages& tree = *method.tree;
    const bool by_errors = method.rule == LodRule::errors;
    const auto make = [&](const LodGain& gain, const LodLimit& limit, float guess) {
      return StreamedCut{tree, cut_of(tree, gain, limit, *session_.pool, guess)};
    };
    std::vector<LodView> views;
    for (const LodShot& shot : shots) {
      LodView& view = views.emplace_back(camera_of(method, shot), kOutside);
      if (by_errors)
        view.surfaces = finder_.surfaces(view, tree.footprint, {count}, dilation(), make);
    }
    const LodGain gain =
        by_errors ? gain_in(views, tree.footprint)
        : method.rule == LodRule::distance
            ? gain_by_distance(views)
            : LodGain([this](const LodPage&, std::size_t row) { return octree_.order[row]; });
    const LodCut cut =
        in_view ? cut_in_view(tree, gain, count, shots[0].nodes.at(method.tree), *session_.pool)
                : cut_of(tree, gain, {count}, *session_.pool);
    std::vector<LodLevel> levels;
    for (const LodView& view : views)
      levels.push_back({std::make_shared<const GaussianCloud>(
                            cut_cloud(tree, cut, view, by_errors ? dilation() : 0, *session_.pool)),
                        cut});
    return levels;
  }

  double dilation() const { return filter_of(session_.settings, leaves().antialiased); }

  // A picture of the roots of the estimated squared errors.
  Image estimate(const LodPages& tree, const LodLevel& level, const Camera& camera) {
    RenderSettings settings = session_.settings;
    settings.background = {};
    GaussianCloud errors = *level.drawn;
    paint_levels(tree, level.cut, LodView(camera, 1), dilation(), true, errors);
    session_.renderer->upload(std::move(errors), {});
    Image roots = session_.renderer->render(camera, settings).color;
    for (float& value : roots.values) value = std::sqrt(value / 3);
    return roots;
  }

  void draw(const Key& key, bool in_view, std::span<const LodLevel> levels,
            std::span<const LodShot> views) {
    for (std::size_t i = 0; i < views.size(); ++i) draw(key, in_view, levels[i], views[i]);
  }

  void draw(const Key& key, bool in_view, const LodLevel& level, const LodShot& view) {
    const LodMethod& method = methods_[std::get<2>(key)];
    const Camera camera = camera_of(method, view);
    session_.renderer->upload(level.drawn, {});
    std::vector<double> times;
    Image image;
    for (int i = -bench_.warmup; i < bench_.frames; ++i) {
      const Frame& frame = session_.renderer->render(camera, session_.settings);
      if (i >= 0) times.push_back(static_cast<double>(frame.stats.frame_ms));
      if (i == bench_.frames - 1) image = frame.color;
    }
    const std::string name =
        view.shot.number < 0 ? view.shot.origin : fmt::format("{}", view.shot.number);
    const PicturePair pair = judge_pictures(name, view.truth, std::move(image), *session_.pool);
    const PictureQuality& q = pair.quality;
    const double worst = worst_block_psnr(pair.truth, pair.judged), ms = median(times);
    LodCell& cell = cells_[key][in_view ? 1 : 0];
    cell.views.push_back(q);
    cell.worst_block = std::min(cell.worst_block, worst);
    cell.gaussians += static_cast<double>(level.drawn->size());
    cell.ms += ms;
    std::string comparison = ",";
    if (method.rule == LodRule::errors) {
      const Image roots = estimate(*method.tree, level, camera);
      std::vector<double> guess = block_errors(roots, Image(q.width, q.height, 3)),
                          error = block_errors(pair.truth, pair.judged);
      for (std::size_t i = error.size(); i-- > 0;)  // blocks that are equal do not count
        if (error[i] == 0)
          for (auto* list : {&guess, &error})
            list->erase(list->begin() + static_cast<std::ptrdiff_t>(i));
      for (std::size_t i = 0; i < error.size(); ++i)
        blocks_[distance_].push_back(fmt::format("{:.4g} {:.4g}", guess[i], error[i]));
      if (const auto correlation = rank_correlation(guess, error)) {
        cell.correlations.push_back(*correlation);
        comparison = fmt::format("{:.4f},{:.4f}", *correlation,
                                 summarise(guess).mean / summarise(error).mean);
      }
    }
    csv_ += fmt::format("{},{},{},{},{:.4g},{},{},{},{},{:.4f},{:.6f},{:.6f},{:.4f},{:.3f},{}",
                        csv_field(scene_), csv_field(name), kDistances[distance_].name,
                        in_view ? "in view" : "all", std::get<double>(key), csv_field(method.name),
                        level.drawn->size(), q.width, q.height, q.psnr, q.ssim, q.flip, worst, ms,
                        comparison);
    csv_ += altered_.empty() ? "\n" : "," + csv_field(altered_) + "\n";
  }

  // Estimated and measured errors of blocks, if a tree has estimates.
  std::vector<Plot> error_plots() const {
    std::string commands =
        "set logscale xy\nset format xy '%.0e'\nset key bottom right\n"
        "set xlabel 'estimated squared error of a block'\n"
        "set ylabel 'measured squared error'\n";
    constexpr std::array kColors = {kVermillion, kGreen, kBlue};
    std::vector<std::string> curves = {"x with lines dashtype 2 linecolor 'grey' title 'equal'"};
    for (std::size_t i = 0; i < kDistances.size(); ++i) {
      if (blocks_[i].empty()) continue;
      commands += data_block(kDistances[i].name, blocks_[i]);
      curves.push_back(fmt::format("${} with points pointtype {} pointsize 0.7 {} title {}",
                                   kDistances[i].name, 4 + 2 * i, color_option(kColors[i]),
                                   quoted(kDistances[i].name)));
    }
    if (curves.size() == 1) return {};
    return {{"lod_errors", "Estimated and measured errors of levels of detail",
             fmt::format("{}: blocks of 64 x 64 pixels, all budgets, mean squared difference of "
                         "colours 0 to 1",
                         scene_),
             commands + plot_command(curves), altered_}};
  }

  std::string table() const {
    std::string text =
        "| distance | budget | method | Gaussians | PSNR dB | SSIM | FLIP | worst block dB | rank "
        "| ms | in view: Gaussians | PSNR dB | SSIM | FLIP | worst block dB | rank | ms |\n"
        "|---|---:|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|\n";
    for (const auto& [key, cells] : cells_) {
      const auto& [distance, budget, method] = key;
      text += fmt::format("| {} | {:.3g} % | {} |{}{}\n", kDistances[distance].name, budget,
                          markdown_text(methods_[method].name), cells[0].text(), cells[1].text());
    }
    return text;
  }

  const LodBench& bench_;
  Session session_;
  const std::string scene_ = scene_name(session_.scene->path);
  const std::string altered_ = alterations_of(session_).text;
  SurfaceFinder finder_{*session_.pool};
  const Octree octree_;
  std::vector<LodMethod> methods_;
  std::vector<LodShot> views_;
  std::map<Key, std::array<LodCell, 2>> cells_;
  std::string csv_;  // its rows
  // By distance: the estimated and the measured error of each block.
  std::array<std::vector<std::string>, kDistances.size()> blocks_;
  std::size_t distance_ = 0;  // of the pictures that are drawn
  ProgressBar bar_{"levels"};
  Progress progress_;
};

}  // namespace

void run_lod_bench(const LodBench& bench) { LodRun(bench).run(); }

}  // namespace qs
