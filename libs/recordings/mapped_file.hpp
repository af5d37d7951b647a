#pragma once
#include <string>

#include <lcmslam/recordings/byte_reader.hpp>

namespace lcmslam {

/// A file in memory, read only: pages come when they are read and go when memory is short. It must not be
/// made shorter meanwhile.
class MappedFile {
 public:
  /// Throws std::runtime_error, naming the file, unless it is a regular file that is not empty.
  explicit MappedFile(const std::string& file);
  ~MappedFile();
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;

  ByteView bytes() const { return {static_cast<const std::uint8_t*>(data_), size_}; }

 private:
  void* data_ = nullptr;
  std::size_t size_ = 0;
};

}  // namespace lcmslam
