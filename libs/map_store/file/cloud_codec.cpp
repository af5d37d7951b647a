// Clouds: for each axis and colour the differences from one point to the next, each byte of them in a row of
// its own. Neighbours in the file are neighbours in the image, so that most of these rows are nearly empty
// and deflate well.

#include <cmath>
#include <limits>

#include <lcmslam/map_store/file/store_codecs.hpp>

namespace lcmslam {
namespace {

constexpr std::int32_t unknown_position = std::numeric_limits<std::int32_t>::min();
constexpr std::size_t bytes_without_normals = 3 * 4 + 3, bytes_of_normal = 3;

/// 0, -1, 1, -2, ... become 0, 1, 2, 3, ...: small differences have empty upper bytes.
std::uint32_t zigzag(std::uint32_t difference) {
  return (difference << 1) ^ (0U - (difference >> 31));
}

std::uint32_t unzigzag(std::uint32_t code) {
  return (code >> 1) ^ (0U - (code & 1U));
}

std::int32_t quantised(float metres) {
  const double value = static_cast<double>(metres);
  return std::abs(value) <= farthest ? static_cast<std::int32_t>(std::lround(value / cloud_unit))
                                     : unknown_position;
}

void put_axis(BlobWriter& writer, const ColouredCloud& cloud, int axis) {
  const std::size_t n = cloud.size();
  std::uint8_t* row = writer.grow(4 * n);
  std::uint32_t last = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const auto now = static_cast<std::uint32_t>(quantised(cloud.points[i](axis)));
    const std::uint32_t code = zigzag(now - last);
    for (std::size_t byte = 0; byte < 4; ++byte)
      row[byte * n + i] = static_cast<std::uint8_t>(code >> (8 * byte));
    last = now;
  }
}

void take_axis(BlobReader& reader, ColouredCloud& cloud, int axis) {
  const std::size_t n = cloud.size();
  const std::uint8_t* row = reader.take_bytes(4 * n);
  std::uint32_t position = 0;
  for (std::size_t i = 0; i < n; ++i) {
    std::uint32_t code = 0;
    for (std::size_t byte = 0; byte < 4; ++byte)
      code |= static_cast<std::uint32_t>(row[byte * n + i]) << (8 * byte);
    position += unzigzag(code);
    const auto units = static_cast<std::int32_t>(position);
    cloud.points[i](axis) = units == unknown_position ? std::numeric_limits<float>::quiet_NaN()
                                                      : static_cast<float>(cloud_unit * units);
  }
}

// Green, and how blue and red differ from it: greys have two empty rows.
void put_colours(BlobWriter& writer, const ColouredCloud& cloud) {
  const std::size_t n = cloud.size();
  std::uint8_t* row = writer.grow(3 * n);
  cv::Vec3b last(0, 0, 0);
  for (std::size_t i = 0; i < n; ++i) {
    const cv::Vec3b& now = cloud.colours[i];
    const int green = now[1] - last[1];
    row[i] = static_cast<std::uint8_t>(green);
    row[n + i] = static_cast<std::uint8_t>(now[0] - last[0] - green);
    row[2 * n + i] = static_cast<std::uint8_t>(now[2] - last[2] - green);
    last = now;
  }
}

void take_colours(BlobReader& reader, ColouredCloud& cloud) {
  const std::size_t n = cloud.size();
  const std::uint8_t* row = reader.take_bytes(3 * n);
  cv::Vec3b last(0, 0, 0);
  for (std::size_t i = 0; i < n; ++i) {
    last = {static_cast<std::uint8_t>(last[0] + row[n + i] + row[i]),
            static_cast<std::uint8_t>(last[1] + row[i]),
            static_cast<std::uint8_t>(last[2] + row[2 * n + i] + row[i])};
    cloud.colours[i] = last;
  }
}

/// 0 0 0 where unknown.
void put_normals(BlobWriter& writer, const ColouredCloud& cloud) {
  const std::size_t n = cloud.size();
  std::uint8_t* row = writer.grow(bytes_of_normal * n);
  for (std::size_t i = 0; i < n; ++i) {
    const Eigen::Vector3f& normal = cloud.normals[i];
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const float part = normal.allFinite() ? normal(static_cast<Eigen::Index>(axis)) : 0.F;
      row[axis * n + i] =
          static_cast<std::uint8_t>(static_cast<std::int8_t>(std::lround(127 * std::clamp(part, -1.F, 1.F))));
    }
  }
}

void take_normals(BlobReader& reader, ColouredCloud& cloud) {
  const std::size_t n = cloud.size();
  const std::uint8_t* row = reader.take_bytes(bytes_of_normal * n);
  cloud.normals.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    Eigen::Vector3f normal;
    for (std::size_t axis = 0; axis < 3; ++axis)
      normal(static_cast<Eigen::Index>(axis)) =
          static_cast<float>(static_cast<std::int8_t>(row[axis * n + i]));
    cloud.normals[i] = normal.isZero() ? Eigen::Vector3f::Constant(std::nanf("")) : normal.normalized();
  }
}

}  // namespace

Blob encode_cloud(const ColouredCloud& cloud) {
  BlobWriter writer;
  writer.put(static_cast<std::uint32_t>(cloud.size()));
  writer.put(static_cast<std::uint8_t>(cloud.normals.empty() ? 0 : 1));
  for (int axis = 0; axis < 3; ++axis) put_axis(writer, cloud, axis);
  put_colours(writer, cloud);
  if (!cloud.normals.empty()) put_normals(writer, cloud);
  return writer.seal(BlobKind::cloud, true);
}

ColouredCloud decode_cloud(const Blob& blob) {
  BlobReader reader(blob, BlobKind::cloud, true);
  const std::size_t n = reader.take<std::uint32_t>();
  const auto normals = reader.take<std::uint8_t>();
  if (normals > 1 || reader.left() != n * (bytes_without_normals + (normals == 1 ? bytes_of_normal : 0)))
    throw BlobError("the blob's length does not fit its " + std::to_string(n) + " points");
  ColouredCloud cloud;
  cloud.points.resize(n);
  cloud.colours.resize(n);
  for (int axis = 0; axis < 3; ++axis) take_axis(reader, cloud, axis);
  take_colours(reader, cloud);
  if (normals == 1 && n > 0) take_normals(reader, cloud);
  return cloud;
}

}  // namespace lcmslam
