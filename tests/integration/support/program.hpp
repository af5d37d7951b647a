#pragma once
// A program that a test starts, watches and stops.

#include <sys/types.h>
#include <filesystem>
#include <string>
#include <vector>

namespace lcmslam::integration {

/// How a program ended.
struct Ending {
  bool ended = false;
  int exit_code = -1;  ///< -1: ended by a signal, or not ended
  int signal = 0;
};

/// Its standard output and error go to one file. At the end of its life it and all that it has started are
/// killed (-9): no straggler meets the next test. The kernel kills it should the test itself die.
class Program {
 public:
  /// `arguments`: program first; one without '/' is looked for where the programs were built, then in PATH.
  explicit Program(std::vector<std::string> arguments, const std::filesystem::path& folder = ".");
  ~Program();
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  pid_t pid() const { return pid_; }
  /// All that it has written so far.
  std::string output() const;
  bool wrote(const std::string& text) const { return output().find(text) != std::string::npos; }
  void send(int signal) const;
  bool running() { return !poll().ended; }
  /// Waits for its end, up to the time.
  Ending wait(double seconds);

 private:
  Ending poll();

  pid_t pid_ = 0;
  std::string file_;
  Ending ending_;
};

/// Runs to the end: exit code and output. A program that hangs is killed after the time; exit code -1.
struct Result {
  int exit_code = -1;
  std::string output;
};
Result run(std::vector<std::string> arguments, double seconds);

/// True while the process exists (a zombie does not).
bool process_exists(pid_t pid);

/// Where the kernel finds the program of this name.
std::string find_program(const std::string& name);

}  // namespace lcmslam::integration
