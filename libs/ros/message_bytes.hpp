#pragma once
// The fields of a ROS message one after another: as ROS 1 lays them out (packed), and as ROS 2 does (CDR:
// each number at a multiple of its size, either byte order, an end mark on texts).

#include <array>
#include <optional>
#include <string>
#include <vector>

#include <lcmslam/geometry/transform.hpp>
#include <lcmslam/recordings/byte_reader.hpp>
#include <lcmslam/recordings/byte_writer.hpp>

namespace lcmslam {

/// When something was measured, and in which frame.
struct RosHeader {
  Utime utime = 0;  ///< 0: the writer did not say
  std::string frame;
};

/// All functions throw RecordingError when the bytes are not there.
class RosReader {
 public:
  /// `encoding` is "ros1" or "cdr"; throws RecordingError for another.
  RosReader(ByteView message, const std::string& encoding);

  template <class T>
  T number() {
    align(sizeof(T));
    std::array<std::uint8_t, sizeof(T)> bytes;
    std::memcpy(bytes.data(), reader_.take(sizeof(T)).data, sizeof(T));
    if (big_endian_)
      for (std::size_t i = 0; i < sizeof(T) / 2; ++i) std::swap(bytes[i], bytes[sizeof(T) - 1 - i]);
    T value;
    std::memcpy(&value, bytes.data(), sizeof(T));
    return value;
  }
  std::string text();
  std::string frame();            ///< a text that names a frame
  ByteView bytes();               ///< uint8[]
  std::vector<double> doubles();  ///< float64[]
  template <std::size_t n>
  std::array<double, n> doubles() {  ///< float64[n]
    std::array<double, n> values;
    for (double& value : values) value = number<double>();
    return values;
  }
  std::uint32_t count();  ///< of an array's elements, each of a byte at least
  RosHeader header();
  Eigen::Vector3d vector();
  Eigen::Isometry3d pose();  ///< also a Transform; throws RecordingError when that is none
  std::optional<Eigen::Isometry3d>
  pose_or_nothing();  ///< nothing when that is none; what follows can be read

  /// To be called at the message's end: throws RecordingError when more follows than padding.
  void finish() const;

 private:
  void align(std::size_t size);
  [[noreturn]] void count_fails(std::uint32_t elements) const;

  ByteReader reader_;
  bool is_ros1_ = true;
  bool big_endian_ = false;
  std::size_t largest_alignment_ = 1;
};

/// ROS 2's layout, little-endian.
class CdrWriter {
 public:
  CdrWriter() { bytes_.number(std::uint32_t{0x100}); }  // plain, little-endian

  template <class T>
  void number(T value) {
    align(sizeof(T));
    bytes_.number(value);
  }
  void text(std::string_view text);
  void bytes(ByteView bytes);
  void count(std::size_t elements) { number(static_cast<std::uint32_t>(elements)); }
  void numbers(const double* values, std::size_t size) {
    for (std::size_t i = 0; i < size; ++i) number(values[i]);
  }
  void header(const RosHeader& header);
  void pose(const Eigen::Isometry3d& pose);

  ByteView view() const { return bytes_.view(); }

 private:
  void align(std::size_t size);

  ByteWriter bytes_;
};

}  // namespace lcmslam
