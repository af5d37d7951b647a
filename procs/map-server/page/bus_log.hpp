#pragma once
// A log of the bus that an operator starts and stops: the stock lcm-logger, beside this process.

#include <sys/types.h>
#include <filesystem>

namespace lcmslam {

class BusLog {
 public:
  /// Logs go into the folder: log-1.lcmlog, log-2.lcmlog, ... Nothing that is there is written over.
  explicit BusLog(std::filesystem::path folder) : folder_(std::move(folder)) {}
  /// Stops it.
  ~BusLog();
  BusLog(const BusLog&) = delete;
  BusLog& operator=(const BusLog&) = delete;

  /// The file that is written. Throws std::runtime_error in words for who asked.
  std::filesystem::path start();
  /// The file that was written; it is whole then. Throws likewise, also when the logger had ended by itself.
  std::filesystem::path stop();
  /// The file that is written; empty: none. Of a logger that ended by itself until stop() has said so.
  std::filesystem::path file() const { return logger_ == 0 ? std::filesystem::path() : file_; }

 private:
  bool is_running();

  std::filesystem::path folder_, file_;
  pid_t logger_ = 0;  // 0: none
};

}  // namespace lcmslam
