#include <lcmslam/map_store/file/store_codecs.hpp>

#include <algorithm>
#include <cmath>

namespace lcmslam {
namespace {

constexpr std::size_t feature_bytes = 5 * 4 + 3 + 4 * 4 + 4 + 3 + 64;
constexpr std::size_t stored_pose_bytes = 8 + 7 * 8;
constexpr std::size_t longest_name = 1000;

double checked(double number, const char* what) {
  if (!std::isfinite(number)) throw BlobError(std::string("the ") + what + " is not finite");
  return number;
}

void put_pose(BlobWriter& writer, const Eigen::Isometry3d& pose) {
  const Eigen::Quaterniond q(pose.rotation());
  for (const double number :
       {pose.translation().x(), pose.translation().y(), pose.translation().z(), q.w(), q.x(), q.y(), q.z()})
    writer.put(number);
}

Eigen::Isometry3d take_pose(BlobReader& reader) {
  double numbers[7];
  for (double& number : numbers) number = checked(reader.take<double>(), "pose");
  const Eigen::Quaterniond q(numbers[3], numbers[4], numbers[5], numbers[6]);
  if (std::abs(q.squaredNorm() - 1) > 1e-6) throw BlobError("the pose's quaternion is no unit one");
  return Eigen::Translation3d(numbers[0], numbers[1], numbers[2]) * q.normalized();
}

/// The upper triangle, as floats, row by row.
template <class Matrix>
void put_symmetric(BlobWriter& writer, const Matrix& matrix) {
  for (Eigen::Index row = 0; row < matrix.rows(); ++row)
    for (Eigen::Index column = row; column < matrix.cols(); ++column)
      writer.put(static_cast<float>(matrix(row, column)));
}

template <class Matrix>
Matrix take_symmetric(BlobReader& reader) {
  Matrix matrix;
  for (Eigen::Index row = 0; row < matrix.rows(); ++row)
    for (Eigen::Index column = row; column < matrix.cols(); ++column)
      matrix(row, column) = matrix(column, row) =
          checked(static_cast<double>(reader.take<float>()), "covariance");
  return matrix;
}

void put_name(BlobWriter& writer, const std::string& name) {
  const std::size_t length = std::min(name.size(), longest_name);
  writer.put(static_cast<std::uint32_t>(length));
  std::copy_n(name.begin(), length, writer.grow(length));
}

std::string take_name(BlobReader& reader) {
  const std::size_t length = reader.take<std::uint32_t>();
  const std::uint8_t* name = reader.take_bytes(length);
  return {name, name + length};
}

void put_image(BlobWriter& writer, const EncodedImage& image) {
  writer.put(image.utime);
  writer.put(static_cast<std::int32_t>(image.width));
  writer.put(static_cast<std::int32_t>(image.height));
  writer.put(static_cast<std::uint8_t>(image.coding));
  writer.put(static_cast<std::uint32_t>(image.bytes.size()));
  std::copy(image.bytes.begin(), image.bytes.end(), writer.grow(image.bytes.size()));
}

EncodedImage take_image(BlobReader& reader) {
  EncodedImage image;
  image.utime = reader.take<Utime>();
  image.width = reader.take<std::int32_t>();
  image.height = reader.take<std::int32_t>();
  const auto coding = reader.take<std::uint8_t>();
  if (coding > static_cast<std::uint8_t>(ImageCoding::gray_zlib))
    throw BlobError("there is no coding " + std::to_string(coding) + " of images");
  image.coding = static_cast<ImageCoding>(coding);
  const std::size_t size = reader.take<std::uint32_t>();
  const std::uint8_t* bytes = reader.take_bytes(size);
  image.bytes.assign(bytes, bytes + size);
  return image;
}

void put_feature(BlobWriter& writer, const Feature& f) {
  for (const float number :
       {f.x, f.y, f.size, f.angle, f.response, f.point.x(), f.point.y(), f.point.z(), f.depth_sigma})
    writer.put(number);
  writer.put(f.laplacian);
  writer.put(f.octave);
  writer.put(static_cast<std::uint8_t>(f.kind));
  writer.put(f.landmark_id);
  std::copy(f.colour.begin(), f.colour.end(), writer.grow(f.colour.size()));
  std::copy(f.descriptor.begin(), f.descriptor.end(), writer.grow(f.descriptor.size()));
}

Feature take_feature(BlobReader& reader) {
  Feature f;
  for (float* number :
       {&f.x, &f.y, &f.size, &f.angle, &f.response, &f.point.x(), &f.point.y(), &f.point.z(), &f.depth_sigma})
    *number = reader.take<float>();
  for (const float number : {f.x, f.y, f.size, f.angle, f.response})
    checked(static_cast<double>(number), "feature");
  f.laplacian = reader.take<std::int8_t>();
  f.octave = reader.take<std::int8_t>();
  const auto kind = reader.take<std::uint8_t>();
  if (kind > static_cast<std::uint8_t>(MeasurementKind::range_bearing))
    throw BlobError("there is no feature of kind " + std::to_string(kind));
  f.kind = static_cast<MeasurementKind>(kind);
  f.landmark_id = reader.take<std::int32_t>();
  std::copy_n(reader.take_bytes(f.colour.size()), f.colour.size(), f.colour.begin());
  std::copy_n(reader.take_bytes(f.descriptor.size()), f.descriptor.size(), f.descriptor.begin());
  return f;
}

}  // namespace

Blob encode_features(const FeatureFrame& frame) {
  BlobWriter writer;
  writer.put(frame.utime);
  writer.put(frame.seq);
  put_name(writer, frame.sensor);
  writer.put(static_cast<std::int32_t>(frame.width));
  writer.put(static_cast<std::int32_t>(frame.height));
  for (const double number : {frame.fx, frame.fy, frame.cx, frame.cy, frame.pixel_sigma}) writer.put(number);
  writer.put(frame.sharpness);
  writer.put(static_cast<std::uint8_t>(frame.has_mount));
  put_pose(writer, frame.T_robot_camera);
  writer.put(static_cast<std::uint32_t>(frame.features.size()));
  for (const Feature& feature : frame.features) put_feature(writer, feature);
  return writer.seal(BlobKind::features, true);
}

FeatureFrame decode_features(const Blob& blob) {
  BlobReader reader(blob, BlobKind::features, true);
  FeatureFrame frame;
  frame.utime = reader.take<Utime>();
  frame.seq = reader.take<std::int64_t>();
  frame.sensor = take_name(reader);
  frame.width = reader.take<std::int32_t>();
  frame.height = reader.take<std::int32_t>();
  for (double* number : {&frame.fx, &frame.fy, &frame.cx, &frame.cy, &frame.pixel_sigma})
    *number = checked(reader.take<double>(), "camera");
  frame.sharpness = reader.take<float>();
  frame.has_mount = reader.take<std::uint8_t>() != 0;
  frame.T_robot_camera = take_pose(reader);
  const std::size_t n = reader.take<std::uint32_t>();
  if (reader.left() != n * feature_bytes)
    throw BlobError("the blob's length does not fit its " + std::to_string(n) + " features");
  frame.features.reserve(n);
  for (std::size_t i = 0; i < n; ++i) frame.features.push_back(take_feature(reader));
  return frame;
}

Blob encode_images(const StoredImages& images) {
  BlobWriter writer;
  writer.put(images.frame.utime);
  writer.put(images.frame.seq);
  put_name(writer, images.frame.sensor);
  put_pose(writer, images.T_colour_depth_time);
  put_image(writer, images.frame.colour);
  put_image(writer, images.frame.depth);
  return writer.seal(BlobKind::images, false);
}

StoredImages decode_images(const Blob& blob) {
  BlobReader reader(blob, BlobKind::images, false);
  StoredImages images;
  images.frame.utime = reader.take<Utime>();
  images.frame.seq = reader.take<std::int64_t>();
  images.frame.sensor = take_name(reader);
  images.T_colour_depth_time = take_pose(reader);
  images.frame.colour = take_image(reader);
  images.frame.depth = take_image(reader);
  reader.expect_end();
  return images;
}

Blob encode_landmark(const Landmark& landmark) {
  BlobWriter writer;
  writer.put(landmark.id);
  for (const double number : {landmark.mean.x(), landmark.mean.y(), landmark.mean.z()}) writer.put(number);
  put_symmetric(writer, landmark.covariance);
  writer.put(static_cast<std::int32_t>(landmark.observations));
  writer.put(static_cast<float>(landmark.log_odds));
  writer.put(landmark.laplacian);
  std::copy(landmark.colour.begin(), landmark.colour.end(), writer.grow(landmark.colour.size()));
  std::copy(landmark.descriptor.begin(), landmark.descriptor.end(), writer.grow(landmark.descriptor.size()));
  return writer.seal(BlobKind::landmark, false);
}

Landmark decode_landmark(const Blob& blob) {
  BlobReader reader(blob, BlobKind::landmark, false);
  Landmark landmark;
  landmark.id = reader.take<std::int64_t>();
  for (double& number : landmark.mean) number = checked(reader.take<double>(), "landmark");
  landmark.covariance = take_symmetric<Eigen::Matrix3d>(reader);
  landmark.observations = reader.take<std::int32_t>();
  landmark.log_odds = checked(static_cast<double>(reader.take<float>()), "landmark");
  landmark.laplacian = reader.take<std::int8_t>();
  std::copy_n(reader.take_bytes(landmark.colour.size()), landmark.colour.size(), landmark.colour.begin());
  std::copy_n(reader.take_bytes(landmark.descriptor.size()), landmark.descriptor.size(),
              landmark.descriptor.begin());
  reader.expect_end();
  return landmark;
}

Blob encode_pose(const Eigen::Isometry3d& pose) {
  BlobWriter writer;
  put_pose(writer, pose);
  return writer.seal(BlobKind::pose, false);
}

Eigen::Isometry3d decode_pose(const Blob& blob) {
  BlobReader reader(blob, BlobKind::pose, false);
  const Eigen::Isometry3d pose = take_pose(reader);
  reader.expect_end();
  return pose;
}

Blob encode_covariance(const Matrix6d& covariance) {
  BlobWriter writer;
  put_symmetric(writer, covariance);
  return writer.seal(BlobKind::covariance, false);
}

Matrix6d decode_covariance(const Blob& blob) {
  BlobReader reader(blob, BlobKind::covariance, false);
  const auto covariance = take_symmetric<Matrix6d>(reader);
  reader.expect_end();
  return covariance;
}

Blob encode_edge(const StoredEdge& edge) {
  BlobWriter writer;
  writer.put(static_cast<std::int32_t>(edge.kind));
  put_pose(writer, edge.T_from_to);
  for (const float number : {edge.sigma_translation, edge.sigma_rotation, edge.error}) writer.put(number);
  return writer.seal(BlobKind::edge, false);
}

StoredEdge decode_edge(const Blob& blob) {
  BlobReader reader(blob, BlobKind::edge, false);
  StoredEdge edge;
  edge.kind = reader.take<std::int32_t>();
  edge.T_from_to = take_pose(reader);
  for (float* number : {&edge.sigma_translation, &edge.sigma_rotation, &edge.error})
    *number = reader.take<float>();
  reader.expect_end();
  return edge;
}

Blob encode_trajectory(const std::vector<StoredPose>& poses) {
  BlobWriter writer;
  for (const StoredPose& pose : poses) {
    writer.put(pose.utime);
    put_pose(writer, pose.T_map_robot);
  }
  return writer.seal(BlobKind::trajectory, true);
}

std::vector<StoredPose> decode_trajectory(const Blob& blob) {
  BlobReader reader(blob, BlobKind::trajectory, true);
  std::vector<StoredPose> poses(reader.left() / stored_pose_bytes);
  for (StoredPose& pose : poses) {
    pose.utime = reader.take<Utime>();
    pose.T_map_robot = take_pose(reader);
  }
  reader.expect_end();
  return poses;
}

Blob encode_bytes(const std::vector<std::uint8_t>& bytes) {
  BlobWriter writer;
  std::copy(bytes.begin(), bytes.end(), writer.grow(bytes.size()));
  return writer.seal(BlobKind::calibration, false);
}

std::vector<std::uint8_t> decode_bytes(const Blob& blob) {
  BlobReader reader(blob, BlobKind::calibration, false);
  const std::size_t size = reader.left();
  const std::uint8_t* bytes = reader.take_bytes(size);
  return {bytes, bytes + size};
}

}  // namespace lcmslam
