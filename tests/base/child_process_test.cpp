// SPDX-License-Identifier: MIT
#include "base/child_process.h"

#include <array>
#include <csignal>
#include <cstring>
#include <fstream>
#include <set>

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include "support/error_of.h"
#include "support/temporary_folder.h"

namespace qs {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr ChildCommand::Socket kInput = {SOCK_STREAM, STDIN_FILENO};

ChildCommand shell(const std::string& script) {
  return {.words = {"sh", "-c", script}, .keeps_messages = true};
}

ChildCommand fed_shell(const std::string& script) {
  ChildCommand command = shell(script);
  command.socket = kInput;
  return command;
}

/// The text that the command writes to stderr.
std::string said(const ChildCommand& command) {
  ChildProcess process(command);
  EXPECT_TRUE(process.wait().good());
  return process.messages(100'000);
}

std::span<const std::byte> bytes_of(const std::string& text) {
  return std::as_bytes(std::span(text));
}

std::set<std::string> open_descriptors(const std::string& folder = "/proc/self/fd") {
  std::set<std::string> links;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    std::error_code gone;  // the iterator's own
    const auto target = std::filesystem::read_symlink(entry.path(), gone);
    links.insert(entry.path().filename().string() + " " + target.string());
  }
  return links;
}

TEST(ChildProcess, tells_its_exit_code) {
  const ChildEnd good = ChildProcess(shell("exit 0")).wait();
  EXPECT_TRUE(good.good());
  const ChildEnd bad = ChildProcess(shell("exit 3")).wait();
  EXPECT_FALSE(bad.good());
  EXPECT_EQ(bad.exit_code, 3);
  EXPECT_EQ(bad.signal, 0);
  EXPECT_EQ(bad.text(), "exit code 3");
}

TEST(ChildProcess, tells_the_signal_that_ended_it) {
  const ChildEnd end = ChildProcess(shell("kill -TERM $$")).wait();
  EXPECT_FALSE(end.good());
  EXPECT_EQ(end.signal, SIGTERM);
  EXPECT_EQ(end.text(), "signal 15 (Terminated)");
}

TEST(ChildProcess, that_is_missing_is_an_error_and_leaves_no_descriptor) {
  const std::set<std::string> before = open_descriptors();
  ChildCommand command = fed_shell("");
  command.words.front() = "no-such-program";
  const auto start = [&] { ChildProcess process(command); };
  EXPECT_EQ(test::error_of(start, ErrorKind::device),
            "no-such-program does not start: No such file or directory");
  EXPECT_EQ(open_descriptors(), before);
}

TEST(ChildProcess, takes_large_input_while_it_writes_as_much) {
  std::string text(20'000'000, '\0');
  for (std::size_t i = 0; i < text.size(); ++i) text[i] = static_cast<char>(i * i >> 7);
  ChildProcess process(fed_shell("cat >&2"));
  EXPECT_TRUE(process.send(bytes_of(text)));
  process.close_socket();
  EXPECT_TRUE(process.wait().good());
  EXPECT_TRUE(process.messages(text.size() + 1) == text);
  EXPECT_EQ(process.messages(7), text.substr(0, 7));
}

TEST(ChildProcess, that_ends_early_fails_the_sending_and_raises_no_signal) {
  ChildProcess process(fed_shell("echo the disk is full >&2; exit 5"));
  EXPECT_FALSE(process.send(bytes_of(std::string(20'000'000, 'x'))));
  EXPECT_EQ(process.wait().exit_code, 5);
  EXPECT_FALSE(process.running());
  EXPECT_EQ(process.messages(1000), "the disk is full\n");
}

TEST(ChildProcess, that_does_not_end_is_killed) {
  const Clock::time_point start = Clock::now();
  {
    ChildProcess process(fed_shell("exec <&-; exec sleep 1000"));
    EXPECT_FALSE(process.send(bytes_of(std::string(20'000'000, 'x'))));
    EXPECT_EQ(process.wait_for(milliseconds(20)).has_value(), false);
    EXPECT_TRUE(process.running());
    process.kill();
    EXPECT_FALSE(process.running());
    const ChildProcess destroyed(shell("exec sleep 1000"));
  }
  EXPECT_LT(Clock::now() - start, seconds(60));
}

TEST(ChildProcess, that_ends_in_time_tells_how) {
  ChildProcess process(shell("exit 4"));
  const std::optional<ChildEnd> end = process.wait_for(seconds(60));
  ASSERT_TRUE(end);
  EXPECT_EQ(end->exit_code, 4);
}

TEST(ChildProcess, exchanges_whole_messages) {
  ChildCommand command = shell("dd bs=64 count=2 <&3 >&3 2>/dev/null");
  command.socket = {SOCK_SEQPACKET, 3};
  ChildProcess process(command);
  EXPECT_FALSE(process.can_receive(milliseconds(0)));
  std::array<char, 5> answer = {};
  EXPECT_TRUE(process.send(bytes_of("first")));
  EXPECT_TRUE(process.can_receive(seconds(60)));
  EXPECT_TRUE(process.receive(std::as_writable_bytes(std::span(answer))));
  EXPECT_EQ(std::string(answer.data(), answer.size()), "first");
  EXPECT_TRUE(process.send(bytes_of("next")));
  EXPECT_FALSE(process.receive(std::as_writable_bytes(std::span(answer)))) << "one byte is missing";
  EXPECT_TRUE(process.wait().good());
  EXPECT_TRUE(process.can_receive(seconds(60))) << "the end does not block";
  EXPECT_FALSE(process.receive(std::as_writable_bytes(std::span(answer))));
}

TEST(ChildProcess, has_the_named_descriptors_and_no_others) {
  const TemporaryFolder folder;
  std::ofstream stream(folder / "a stream without O_CLOEXEC");
  const ChildProcess other(fed_shell("exec sleep 1000"));
  const Descriptor zero(open("/dev/zero", O_RDONLY)), full(open("/dev/full", O_RDONLY));
  ChildCommand command = shell("echo $$ >&2; exec sleep 1000");
  command.inherits = {{zero.get(), 3}, {full.get(), 4}};
  const ChildProcess process(command);
  const std::set<std::string> expected = {"0 /dev/null", "1 /dev/null",
                                          "2 /memfd:messages of a process (deleted)", "3 /dev/zero",
                                          "4 /dev/full"};
  std::set<std::string> found;
  const Clock::time_point start = Clock::now();
  while (found != expected && Clock::now() - start < seconds(10)) {  // a program opens files first
    const std::string number = process.messages(100);
    if (number.ends_with('\n'))
      found = open_descriptors("/proc/" + number.substr(0, number.size() - 1) + "/fd");
  }
  EXPECT_EQ(found, expected);
}

TEST(ChildProcess, may_have_descriptors_whose_numbers_are_exchanged) {
  const Descriptor zero(open("/dev/zero", O_RDONLY)), full(open("/dev/full", O_RDONLY));
  const auto name = [](int number) { return std::to_string(number); };
  ChildCommand command =
      shell("cd /proc/$$/fd; readlink " + name(zero.get()) + " " + name(full.get()) + " >&2");
  command.inherits = {{zero.get(), full.get()}, {full.get(), zero.get()}};
  EXPECT_EQ(said(command), "/dev/full\n/dev/zero\n");
}

TEST(ChildProcess, leaves_no_descriptor_behind) {
  const std::set<std::string> before = open_descriptors();
  for (int i = 0; i < 3; ++i) ChildProcess(fed_shell("exit 0")).wait();
  { const ChildProcess killed(fed_shell("exec sleep 1000")); }
  EXPECT_EQ(open_descriptors(), before);
}

TEST(ChildProcess, runs_in_its_folder_and_group) {
  const TemporaryFolder folder;
  ChildCommand command = shell(
      "pwd >&2; read -r a b c d group rest < /proc/$$/stat; "
      "[ $group = $$ ] && echo own >&2; true");
  command.folder = std::filesystem::canonical(folder.path());
  EXPECT_EQ(said(command), command.folder.string() + "\n");
  command.own_group = true;
  EXPECT_EQ(said(command), command.folder.string() + "\nown\n");
}

}  // namespace
}  // namespace qs
