#include "tools/output_file.hpp"

#include <stdexcept>

#include <lcmslam/runtime/stop_signal.hpp>

namespace lcmslam {

void check_output_file(const std::filesystem::path& file, bool force) {
  std::error_code ignored;
  if (!std::filesystem::exists(file, ignored)) return;
  if (!force) throw std::runtime_error(file.string() + ": exists; --force overwrites it");
  if (!std::filesystem::is_regular_file(file, ignored))
    throw std::runtime_error(file.string() + ": is no file");
}

void throw_when_stopped() {
  if (stop_requested()) throw std::runtime_error("stopped by a signal: nothing is written");
}

}  // namespace lcmslam
