// SPDX-License-Identifier: MIT
#include "app/plugin/plugin_process.h"

#include <chrono>
#include <span>

#include <sys/socket.h>
#include <unistd.h>

#include "base/assets.h"
#include "base/fail.h"

namespace qs {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kPollPeriod{100};  // a cancellation is noticed within this time
constexpr std::chrono::seconds kTimeToEnd{
    5};  // a process that closed its socket ends within this time

const char* activity(PluginCall call) {
  constexpr const char* kActivities[] = {"while opening the scene", "while rendering",
                                         "while closing the scene"};
  return kActivities[static_cast<int>(call)];
}

ChildCommand host_command(const std::filesystem::path& library, int scene, int image) {
  return {.words = {(program_folder() / "quadsplat").string(), kPluginHostCommand,
                    std::filesystem::absolute(library).string()},
          .socket = {{SOCK_SEQPACKET, kPluginSocket}},
          // stdout is for reports, so the output of a plugin goes to stderr.
          .inherits = {{STDERR_FILENO, STDOUT_FILENO},
                       {STDERR_FILENO, STDERR_FILENO},
                       {scene, kPluginScene},
                       {image, kPluginImage}}};
}

}  // namespace

PluginProcess::PluginProcess(const std::filesystem::path& library, int scene, int image) try
    : process_(host_command(library, scene, image)) {
} catch (const Error& error) {
  fail(error.kind(), "cannot be run, because {}", error.what());
}

PluginReply PluginProcess::request(const PluginRequest& request, int timeout_s,
                                   const std::stop_token& stop) {
  const auto deadline = Clock::now() + std::chrono::seconds(timeout_s);
  if (!process_.send(std::as_bytes(std::span(&request, 1)))) report_end(request.call);
  for (;;) {
    const bool ready = process_.can_receive(kPollPeriod);
    if (stop.stop_requested()) {
      process_.kill();
      throw Cancelled();
    }
    if (ready) break;
    if (Clock::now() < deadline) continue;
    process_.kill();
    timed_out_ = true;
    fail(ErrorKind::device, "did not answer within {} s {}, so its process was ended", timeout_s,
         activity(request.call));
  }
  PluginReply reply;
  if (!process_.receive(std::as_writable_bytes(std::span(&reply, 1)))) report_end(request.call);
  reply.message.back() = reply.name.back() = reply.description.back() = '\0';
  return reply;
}

// The process closed its socket, usually because it ended.
void PluginProcess::report_end(PluginCall call) {
  const std::optional<ChildEnd> end = process_.wait_for(kTimeToEnd);
  if (!end) {
    process_.kill();
    fail(ErrorKind::device, "closed quadsplat's socket {}", activity(call));
  }
  fail(ErrorKind::device, "{} {} {}", end->signal != 0 ? "crashed with" : "ended its process with",
       end->text(), activity(call));
}

}  // namespace qs
