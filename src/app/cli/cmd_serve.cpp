// SPDX-License-Identifier: MIT
//
// quadsplat serve: scenes in the browser of this or another machine.
#include <algorithm>
#include <cstdio>
#include <iterator>
#include <memory>
#include <optional>

#include "app/cli/command.h"
#include "app/cli/serve_options.h"
#include "app/cli/shared_options.h"
#include "app/serve/server.h"
#include "base/fail.h"
#include "base/progress.h"
#include "base/quit_signals.h"
#include "base/warn.h"

namespace qs {
namespace {

constexpr std::size_t kMostSibrName = 1024;

struct ServeCommand {
  FrameOptions frame;
  std::vector<std::filesystem::path> scenes;
  bool answers_sibr = false;
  SibrOptions sibr;
  ServeOptions serve;
};

void check(const FrameOptions& frame) {
  const bool draws_reference = std::ranges::count(frame.modes, kReferenceMode) > 0;
  check_rules(
      "serve",
      {{frame.size.has_value(), "--size: pictures have the size of the browser's window"},
       {draws_reference, "--cull reference takes seconds a picture: use quadsplat render"}});
}

// SIBR's protocol has no token, so its port listens at 127.0.0.1 only.
std::optional<SibrOptions> sibr_options(const ServeCommand& command, Arguments arguments) {
  constexpr const char* kOptions[] = {"--sibr-port", "--sibr-name"};
  const char* const option = given_option(arguments, kOptions);
  if (option != nullptr && !command.answers_sibr)
    fail(ErrorKind::usage, "serve: {}: needs --sibr", option);
  if (!command.answers_sibr) return {};
  const std::string &address = command.serve.address, &name = command.sibr.name;
  if (address != "127.0.0.1" && address != "::1")
    fail(ErrorKind::usage,
         "serve: --address {}: --sibr asks nobody for a token, so it works at 127.0.0.1 only",
         address);
  const auto is_plain = [](char c) { return c >= ' ' && c <= '~'; };
  if (name.size() > kMostSibrName || !std::ranges::all_of(name, is_plain))
    fail(ErrorKind::usage, "serve: --sibr-name: must be ASCII text of at most {} letters",
         kMostSibrName);
  return command.sibr;
}

void print_sibr_address(int port) {
  fmt::print(stderr,
             "SIBR viewers: SIBR_remoteGaussian_app --port {0} --path DATA; from another machine "
             "ssh -L {0}:127.0.0.1:{0} USER@THIS_MACHINE. They see the first scene without a "
             "token.\n",
             port);
}

// scripts/measure_serve reads these lines.
void print_sent(const Server& server) {
  constexpr const char* kCodecs[] = {"", "JPEG", "WebP", "VP9"};  // index = PictureCodec
  for (std::size_t i = 1; i < std::size(kCodecs); ++i) {
    const SentPictures& sent = server.sent()[i];
    if (sent.pictures == 0) continue;
    const auto count = static_cast<double>(sent.pictures);
    fmt::print(stderr,
               "sent {} {} pictures: {:.1f} kB, {:.2f} ms to encode, {:.2f} ms to send each\n",
               sent.pictures, kCodecs[i], static_cast<double>(sent.bytes) / 1e3 / count,
               sent.encode_ms / count, sent.send_ms / count);
  }
}

int serve_scenes(ServeCommand& command, Arguments arguments) {
  check(command.frame);
  ServeOptions& serve = command.serve;
  complete(serve);
  serve.sibr = sibr_options(command, arguments);
  const auto server = make_server(serve);  // throws before the scenes are read
  for (const std::string& sentence : server->warnings()) warn(sentence);
  ServedScenes scenes;
  for (const std::filesystem::path& path : command.scenes) {
    command.frame.scene = path;
    scenes.push_back(open_served_scene(command.frame));
  }
  const std::size_t count = scenes.size();
  print_address(serve, server->port(), fmt::format("{} scene{}", count, count == 1 ? "" : "s"));
  if (serve.sibr) print_sibr_address(server->sibr_port());
  server->run(scenes, QuitSignals::arrived, nullptr);
  print_sent(*server);
  throw Cancelled();  // only a signal ends it
}

}  // namespace

CommandAction serve_command(Options& options) {
  const auto command = std::make_shared<ServeCommand>();
  options.positionals("SCENE", command->scenes, 1, kSceneHelp, kSceneSamples);
  declare_common_options(options, command->frame);
  declare_level_options(options, command->frame.levels);
  declare_serve_options(options, command->serve, {"192.0.2.1", "nowhere"});
  options.flag("--sibr", command->answers_sibr,
               "also answers INRIA's remote viewer (SIBR_remoteGaussian) on this machine");
  options.integer("--sibr-port", "N", 0, 65535, command->sibr.port,
                  "port for that viewer; 0 = any free one (default: 6009)");
  options.text("--sibr-name", "TEXT", command->sibr.name,
               "the folder of the data set at the viewer's machine, which that viewer opens "
               "(default: none)",
               {"/data/garden"});
  options.example("quadsplat serve garden/", "prints the address to open in a browser");
  options.example("quadsplat serve plush.spz garden/ --port 8080",
                  "two scenes, at another port, for ssh -L 8080:127.0.0.1:8080");
  return [command](Arguments arguments) { return serve_scenes(*command, arguments); };
}

}  // namespace qs
