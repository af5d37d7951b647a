#pragma once
// What cameras truly saw at moments that come again, kept so that each lap adds its own noise alone.

#include <cstdint>
#include <cstdio>
#include <map>
#include <memory>
#include <mutex>
#include <opencv2/core.hpp>

#include <lcmslam/geometry/transform.hpp>

namespace lcmslam {

/// Without noise; either may be empty.
struct CameraViews {
  cv::Mat colour, depth;
};

/// In a file without a name in the folder of temporary files, which ends with the process. May be used by
/// several threads.
class KeptViews {
 public:
  /// Keeps no more than so many bytes.
  explicit KeptViews(std::int64_t most_bytes) : most_(most_bytes) {}

  /// False where they are not kept.
  bool find(Utime moment, CameraViews& views) const;
  /// Where the bound or the disk is reached, nothing more is kept.
  void keep(Utime moment, const CameraViews& views);

 private:
  struct Place {
    std::int64_t offset = 0;
    int rows = 0, columns = 0, type = 0;
  };
  struct Entry {
    Place colour, depth;
  };
  bool write(const cv::Mat& image, Place& place);
  bool read(const Place& place, cv::Mat& image) const;

  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  std::int64_t most_;
  std::unique_ptr<std::FILE, Close> file_;
  std::int64_t bytes_ = 0;
  bool full_ = false;
  std::map<Utime, Entry> entries_;
  mutable std::mutex mutex_;
};

}  // namespace lcmslam
