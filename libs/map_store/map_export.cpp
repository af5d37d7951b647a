// PLY is written here and not through PCL, whose writer does not notice a full disk and adds an element
// for the camera that other programs stumble over.

#include <cstdint>
#include <limits>
#include <stdexcept>
#include <string>

#include <lcmslam/cloud/coloured_cloud.hpp>
#include <lcmslam/files/atomic_file.hpp>
#include <lcmslam/map_store/map_export.hpp>

static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "the PLY writer copies little-endian numbers");

namespace lcmslam {
namespace {

template <class Number>
void put(std::string& bytes, Number number) {
  bytes.append(reinterpret_cast<const char*>(&number), sizeof number);
}

void put(std::string& bytes, const Eigen::Vector3f& vector) {
  for (const float coordinate : {vector.x(), vector.y(), vector.z()}) put(bytes, coordinate);
}

std::string header(std::size_t vertices, const std::string& properties) {
  return "ply\nformat binary_little_endian 1.0\ncomment lcmslam map, metres, z up\nelement vertex " +
         std::to_string(vertices) + "\n" + properties + "end_header\n";
}

const std::string position_properties = "property float x\nproperty float y\nproperty float z\n";
const std::string normal_properties = "property float nx\nproperty float ny\nproperty float nz\n";
const std::string colour_properties = "property uchar red\nproperty uchar green\nproperty uchar blue\n";

}  // namespace

void save_ply(const FilePlace& file, const ColouredCloud& cloud) {
  const bool has_normals = cloud.size() > 0 && cloud.normals.size() == cloud.size();
  std::string bytes =
      header(cloud.size(), position_properties + (has_normals ? normal_properties : "") + colour_properties);
  bytes.reserve(bytes.size() + cloud.size() * (has_normals ? 27 : 15));
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    put(bytes, cloud.points[i]);
    if (has_normals) {
      const Eigen::Vector3f& normal = cloud.normals[i];
      put(bytes, normal.allFinite() ? normal : Eigen::Vector3f::Zero().eval());
    }
    for (const int channel : {2, 1, 0}) put(bytes, cloud.colours[i][channel]);
  }
  write_atomically(file, bytes);
}

void save_ply(const FilePlace& file, const std::vector<Landmark>& landmarks) {
  bool wide = false;
  for (const Landmark& landmark : landmarks)
    wide = wide || landmark.id > std::numeric_limits<std::int32_t>::max() ||
           landmark.id < std::numeric_limits<std::int32_t>::min();
  std::string properties = position_properties + colour_properties;
  properties += wide ? "property double id\n" : "property int id\n";
  properties += "property int observations\n";
  for (const char* element : {"xx", "xy", "xz", "yy", "yz", "zz"})
    properties += std::string("property float cov_") + element + "\n";

  std::string bytes = header(landmarks.size(), properties);
  for (const Landmark& landmark : landmarks) {
    put(bytes, landmark.mean.cast<float>().eval());
    for (const std::uint8_t channel : landmark.colour) put(bytes, channel);
    if (wide)
      put(bytes, static_cast<double>(landmark.id));
    else
      put(bytes, static_cast<std::int32_t>(landmark.id));
    put(bytes, static_cast<std::int32_t>(landmark.observations));
    for (int row = 0; row < 3; ++row)
      for (int column = row; column < 3; ++column)
        put(bytes, static_cast<float>(landmark.covariance(row, column)));
  }
  write_atomically(file, bytes);
}

}  // namespace lcmslam
