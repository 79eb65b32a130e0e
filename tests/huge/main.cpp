// SPDX-License-Identifier: MIT
//
// The program of scripts/make_huge: writes large scenes to disk, part by part.
#include <cstdio>
#include <fstream>

#include <fmt/format.h>

#include "app/cli/options.h"
#include "app/session/session.h"
#include "base/fail.h"
#include "base/progress_bar.h"
#include "base/text.h"
#include "huge/city.h"
#include "huge/copies.h"
#include "io/bytes/file_guard.h"
#include "io/bytes/replace_file.h"
#include "io/camera/cameras.h"
#include "io/cloud/cloud_memory.h"
#include "io/scene/ply/ply.h"
#include "io/scene/writer.h"
#include "support/instances_text.h"

namespace qs {
namespace {

constexpr std::size_t kPart = std::size_t{1} << 18;  // Gaussians, 60 MB with SH degree 3

struct HugeCommand {
  std::filesystem::path scene, output;
  int count = 1'000'000, copies = 10, degree = kMaxShDegree, seed = 1, threads = 0;
};

// OUT.ply and OUT.instances.json -> OUT_cameras.json.
std::filesystem::path cameras_of(const std::filesystem::path& output) {
  std::string name = output.filename().string();
  name.erase(name.find('.', 1) == name.npos ? name.size() : name.find('.', 1));
  return output.parent_path() / (name + "_cameras.json");
}

void write_views(const std::vector<Camera>& cameras, const std::filesystem::path& output) {
  std::string text;
  for (const Camera& camera : cameras) text += (text.empty() ? "[" : ",\n") + format_camera(camera);
  write_text(cameras_of(output), text + "]\n");
}

void say_written(const std::filesystem::path& output, std::size_t count) {
  fmt::print("wrote {} ({} Gaussians, {}) and {}\n", output.string(), grouped(count),
             bytes_text(std::filesystem::file_size(output)), cameras_of(output).string());
}

void make_city(const HugeCommand& command) {
  ThreadPool pool(command.threads);
  const City city(static_cast<std::size_t>(command.count), command.degree,
                  static_cast<std::uint64_t>(command.seed));
  ProgressBar bar("city");
  const Progress progress = bar.progress();
  std::size_t done = 0;
  write_ply_parts({city.size(), command.degree, false}, command.output, pool, [&] {
    progress.update(static_cast<float>(done) / static_cast<float>(city.size()));
    const std::size_t begin = done;
    done = std::min(done + kPart, city.size());
    return city.part(begin, done, pool);
  });
  bar.hide();
  write_views(city.cameras(), command.output);
  say_written(command.output, city.size());
}

void make_copies(const HugeCommand& command) {
  ThreadPool pool(command.threads);
  const GaussianCloud one = with_sh_degree(load_scene(command.scene, pool).cloud, command.degree);
  const Copies copies = scatter_copies(one, static_cast<std::size_t>(command.copies),
                                       static_cast<std::uint64_t>(command.seed));
  const std::size_t count = one.size() * copies.instances.size();
  if (command.output.extension() == ".json") {
    std::filesystem::path source = cameras_of(command.output);
    const bool is_tree = command.scene.extension() == ".rad";  // which keeps its levels
    source.replace_filename(command.output.stem().stem().string() + "_source" +
                            (is_tree ? ".rad" : ".ply"));
    if (is_tree)
      std::filesystem::copy_file(command.scene, source,
                                 std::filesystem::copy_options::overwrite_existing);
    else
      write_scene(one, source, pool);
    write_text(command.output,
               test::format_instances(source.filename().string(), copies.instances));
  } else {
    ProgressBar bar("copies");
    const Progress progress = bar.progress();
    std::size_t done = 0;
    write_ply_parts({count, one.sh_degree, one.antialiased}, command.output, pool, [&] {
      progress.update(static_cast<float>(done) / static_cast<float>(copies.instances.size()));
      GaussianCloud part;
      part.resize(one.size(), one.sh_degree);
      place_instance(one, copies.instances[done++], part, 0, pool);
      return part;
    });
  }
  write_views(copies.cameras, command.output);
  say_written(command.output, count);
}

int run(std::vector<std::string> words) {
  HugeCommand command;
  const std::string what = words.empty() ? "" : words[0];
  if (what != "city" && what != "copies")
    fail(ErrorKind::usage, "make_huge: give city or copies, and --help for their options");
  words.erase(words.begin());
  const bool is_city = what == "city";
  Options options("make_huge " + what, is_city ? "writes a seeded city"
                                               : "writes copies of a scene, each with its own "
                                                 "rotation, scale and tint");
  if (!is_city) options.positional("SCENE", command.scene, "splat file or model folder", {});
  options.positional("OUT", command.output,
                     is_city ? ".ply to write" : ".ply or .instances.json to write", {});
  if (is_city)
    options.integer("--count", "N", 1, 2'000'000'000, command.count,
                    "Gaussians (default: 1,000,000)");
  else
    options.integer("--copies", "N", 1, 10'000'000, command.copies, "copies (default: 10)");
  options.integer("--sh-degree", "N", 0, kMaxShDegree, command.degree,
                  "highest degree (default: 3, or the scene's)");
  options.integer("--seed", "N", 0, 2'000'000'000, command.seed, "another scene (default: 1)");
  options.integer("--threads", "N", 0, 1024, command.threads, "0: all (default)");
  options.overwrite();
  if (!options.parse(words)) return 0;
  const FileGuard guard(options.overwrites());
  const std::string name = command.output.filename().string();
  if (!name.ends_with(".ply") && (is_city || !name.ends_with(".instances.json")))
    fail(ErrorKind::usage, "make_huge: {}: the name must end in .ply{}", command.output.string(),
         is_city ? "" : " or .instances.json");
  if (!is_city) note_input(find_scene_file(command.scene));
  check_targets({command.output, cameras_of(command.output)});
  is_city ? make_city(command) : make_copies(command);
  return 0;
}

}  // namespace
}  // namespace qs

int main(int count, char** words) try {
  return qs::run({words + 1, words + count});
} catch (const qs::Error& error) {
  fmt::print(stderr, "{}\n", error.what());
  return 1;
}
