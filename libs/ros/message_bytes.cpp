#include <lcmslam/ros/message_bytes.hpp>

#include <cmath>

namespace lcmslam {
namespace {

constexpr std::size_t encapsulation = 4;  // bytes before a CDR message, which alignment does not count

}  // namespace

RosReader::RosReader(ByteView message, const std::string& encoding) : reader_(message) {
  if (encoding == "ros1") return;
  if (encoding != "cdr")
    throw RecordingError("its encoding '" + encoding + "' is not known: must be ros1 or cdr");
  is_ros1_ = false;
  reader_.take(1);
  const auto kind = reader_.number<std::uint8_t>();
  reader_.take(2);
  if (kind != 0 && kind != 1 && kind != 6 && kind != 7)
    throw RecordingError("its CDR is of kind " + std::to_string(kind) +
                         ": must be plain (0, 1) or plain of version 2 (6, 7)");
  big_endian_ = kind % 2 == 0;
  largest_alignment_ = kind < 2 ? 8 : 4;
}

void RosReader::align(std::size_t size) {
  const std::size_t to = std::min(size, largest_alignment_);
  if (const std::size_t over = is_ros1_ ? 0 : (reader_.position() - encapsulation) % to; over != 0)
    reader_.take(to - over);
}

std::uint32_t RosReader::count() {
  const auto elements = number<std::uint32_t>();
  if (elements > reader_.left()) count_fails(elements);
  return elements;
}

void RosReader::count_fails(std::uint32_t elements) const {
  throw RecordingError("an array of " + std::to_string(elements) + " elements, but only " +
                       std::to_string(reader_.left()) + " bytes follow");
}

std::string RosReader::text() {
  const ByteView bytes = reader_.take(count());
  std::string text(bytes.text());
  if (!is_ros1_ && !text.empty() && text.back() == '\0') text.pop_back();
  return text;
}

std::string RosReader::frame() {
  std::string name = text();
  if (!name.empty() && name.front() == '/') name.erase(0, 1);  // as tf's first version wrote it
  return name;
}

ByteView RosReader::bytes() {
  return reader_.take(count());
}

std::vector<double> RosReader::doubles() {
  const std::uint32_t size = count();
  if (size > reader_.left() / sizeof(double)) count_fails(size);
  std::vector<double> values(size);
  for (double& value : values) value = number<double>();
  return values;
}

RosHeader RosReader::header() {
  if (is_ros1_) number<std::uint32_t>();  // seq
  RosHeader header;
  const auto seconds = number<std::uint32_t>();
  header.utime = Utime{seconds} * 1'000'000 + number<std::uint32_t>() / 1000;
  header.frame = frame();
  return header;
}

Eigen::Vector3d RosReader::vector() {
  const auto values = doubles<3>();
  return {values[0], values[1], values[2]};
}

Eigen::Isometry3d RosReader::pose() {
  if (const auto pose = pose_or_nothing()) return *pose;
  throw RecordingError("a pose whose numbers are not finite or whose quaternion is no unit one");
}

std::optional<Eigen::Isometry3d> RosReader::pose_or_nothing() {
  const Eigen::Vector3d translation = vector();
  const auto q = doubles<4>();  // x, y, z, w
  const Eigen::Quaterniond rotation(q[3], q[0], q[1], q[2]);
  if (!translation.allFinite() || !(std::abs(rotation.norm() - 1) < 0.01)) return std::nullopt;
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translation() = translation;
  pose.linear() = rotation.normalized().toRotationMatrix();
  return pose;
}

void RosReader::finish() const {
  const std::size_t padding = is_ros1_ ? 0 : 7;
  if (reader_.left() > padding)
    throw RecordingError(std::to_string(reader_.left()) +
                         " bytes too many: its type may be another one of the same name");
}

void CdrWriter::align(std::size_t size) {
  while ((bytes_.bytes().size() - encapsulation) % size != 0) bytes_.number(std::uint8_t{0});
}

void CdrWriter::text(std::string_view text) {
  count(text.size() + 1);
  bytes_.raw(text);
  bytes_.number('\0');
}

void CdrWriter::bytes(ByteView bytes) {
  count(bytes.size);
  bytes_.raw(bytes);
}

void CdrWriter::header(const RosHeader& header) {
  number(static_cast<std::int32_t>(header.utime / 1'000'000));
  number(static_cast<std::uint32_t>(header.utime % 1'000'000 * 1000));
  text(header.frame);
}

void CdrWriter::pose(const Eigen::Isometry3d& pose) {
  const Eigen::Vector3d p = pose.translation();
  const Eigen::Quaterniond q(pose.linear());
  for (const double value : {p.x(), p.y(), p.z(), q.x(), q.y(), q.z(), q.w()}) number(value);
}

}  // namespace lcmslam
