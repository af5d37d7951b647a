#include <lcmslam/simulation/kept_views.hpp>

#include <fcntl.h>
#include <unistd.h>
#include <filesystem>

namespace lcmslam {
namespace {

std::FILE* unnamed_file() {
  std::error_code error;
  const std::filesystem::path folder = std::filesystem::temp_directory_path(error);
  const int file = error ? -1 : open(folder.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0600);
  return file < 0 ? std::tmpfile() : fdopen(file, "w+b");
}

/// `transfer` is pread or pwrite. False at the end of the file or the disk.
template <class Byte, class Transfer>
bool whole(Transfer transfer, std::FILE* file, Byte* bytes, std::size_t size, std::int64_t offset) {
  while (size > 0) {
    const ssize_t done = transfer(fileno(file), bytes, size, offset);
    if (done <= 0) return false;
    bytes += done;
    size -= static_cast<std::size_t>(done);
    offset += done;
  }
  return true;
}

std::size_t bytes_of(const cv::Mat& image) {
  return image.total() * image.elemSize();
}

}  // namespace

bool KeptViews::find(Utime moment, CameraViews& views) const {
  const std::lock_guard lock(mutex_);
  const auto entry = entries_.find(moment);
  return entry != entries_.end() && read(entry->second.colour, views.colour) &&
         read(entry->second.depth, views.depth);
}

void KeptViews::keep(Utime moment, const CameraViews& views) {
  const std::lock_guard lock(mutex_);
  if (full_ || entries_.count(moment) > 0) return;
  Entry entry;
  full_ = !write(views.colour, entry.colour) || !write(views.depth, entry.depth);
  if (!full_) entries_[moment] = entry;
}

bool KeptViews::write(const cv::Mat& image, Place& place) {
  const auto size = static_cast<std::int64_t>(bytes_of(image));
  if (bytes_ + size > most_) return false;
  if (!file_) file_.reset(unnamed_file());
  if (!file_ || !whole(pwrite, file_.get(), image.data, bytes_of(image), bytes_)) return false;
  place = {bytes_, image.rows, image.cols, image.type()};
  bytes_ += size;
  return true;
}

bool KeptViews::read(const Place& place, cv::Mat& image) const {
  image.create(place.rows, place.columns, place.type);
  return whole(pread, file_.get(), image.data, bytes_of(image), place.offset);
}

}  // namespace lcmslam
