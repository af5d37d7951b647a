#include "tools/batch/batch_progress.hpp"

#include <fmt/format.h>
#include <ostream>

namespace lcmslam {

std::string format_progress(double elapsed, std::int64_t frame, std::int64_t frames) {
  const std::string line = fmt::format("  {:>3.0f} s  {}  frame {}/{}", elapsed,
                                       frame < frames ? "mapping" : "finishing", frame, frames);
  if (frame == 0) return line;
  return line + fmt::format("  {:.0f} s left",
                            elapsed * static_cast<double>(frames - frame) / static_cast<double>(frame));
}

void ProgressLine::show(double elapsed, std::int64_t frame, std::int64_t frames) {
  if (elapsed - shown_ < (terminal_ ? 1 : 10)) return;
  shown_ = elapsed;
  out_ << (terminal_ ? "\r\x1b[K" : "") << format_progress(elapsed, frame, frames) << (terminal_ ? "" : "\n")
       << std::flush;
}

void ProgressLine::clear() {
  if (terminal_) out_ << "\r\x1b[K" << std::flush;
}

}  // namespace lcmslam
