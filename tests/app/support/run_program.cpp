// SPDX-License-Identifier: MIT
#include "app/support/run_program.h"

#include <cstdlib>
#include <fstream>
#include <iterator>
#include <stdexcept>

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include "support/temporary_folder.h"
#include "support/paths.h"

namespace qs::test {
namespace {

void redirect(int descriptor, const std::filesystem::path& path) {
  const int file = open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  if (file < 0 || dup2(file, descriptor) < 0) _exit(127);
}

}  // namespace

std::string content_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

ProgramRun run_program(const std::string& program, const std::vector<std::string>& arguments,
                       const std::function<void(pid_t)>& meanwhile) {
  const TemporaryFolder folder;
  std::vector<char*> words = {const_cast<char*>(program.c_str())};
  for (const std::string& argument : arguments)
    words.push_back(const_cast<char*>(argument.c_str()));
  words.push_back(nullptr);
  const pid_t child = fork();
  if (child < 0) throw std::runtime_error("fork failed");
  if (child == 0) {
    redirect(STDOUT_FILENO, folder / "out");
    redirect(STDERR_FILENO, folder / "err");
    // OpenImageIO's libraries leak a few bytes at exit.
    setenv("ASAN_OPTIONS", "detect_leaks=0", 1);
    execvp(program.c_str(), words.data());
    _exit(127);
  }
  if (meanwhile) meanwhile(child);
  int status = 0;
  waitpid(child, &status, 0);
  ProgramRun run;
  run.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  run.out = content_of(folder / "out");
  run.err = content_of(folder / "err");
  return run;
}

ProgramRun run_quadsplat(const std::vector<std::string>& arguments,
                         const std::function<void(pid_t)>& meanwhile) {
  return run_program(quadsplat_program(), arguments, meanwhile);
}

}  // namespace qs::test
