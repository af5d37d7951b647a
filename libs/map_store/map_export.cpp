// PLY and PCD are written here and not through PCL: its writers print, cannot say why a disk refuses (or do
// not notice), and add an element for the camera to a PLY that other programs stumble over.

#include <cstdint>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include <lcmslam/cloud/coloured_cloud.hpp>
#include <lcmslam/files/atomic_file.hpp>
#include <lcmslam/map_store/map_export.hpp>

static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "bytes are copied as numbers stand in memory");

namespace lcmslam {
namespace {

template <class Number>
void put(std::string& bytes, Number number) {
  bytes.append(reinterpret_cast<const char*>(&number), sizeof number);
}

void put(std::string& bytes, const Eigen::Vector3f& vector) {
  for (const float coordinate : {vector.x(), vector.y(), vector.z()}) put(bytes, coordinate);
}

std::string ply_header(std::size_t vertices, const std::string& properties) {
  return "ply\nformat binary_little_endian 1.0\ncomment lcmslam map, metres, z up\nelement vertex " +
         std::to_string(vertices) + "\n" + properties + "end_header\n";
}

const std::string position_properties = "property float x\nproperty float y\nproperty float z\n";
const std::string normal_properties = "property float nx\nproperty float ny\nproperty float nz\n";
const std::string colour_properties = "property uchar red\nproperty uchar green\nproperty uchar blue\n";

struct PcdField {
  const char* name;
  char type;  ///< F or U, 4 bytes
};

/// As PCL writes it. Of nothing: ascii, because PCL's reader expects bytes behind "binary".
std::string pcd_header(std::size_t points, const std::vector<PcdField>& fields) {
  std::string names = "FIELDS", sizes = "SIZE", types = "TYPE", counts = "COUNT";
  for (const PcdField& field : fields) {
    names += std::string(" ") + field.name;
    sizes += " 4";
    types += std::string(" ") + field.type;
    counts += " 1";
  }
  const std::string count = std::to_string(points);
  return "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\n" + names + "\n" + sizes + "\n" + types +
         "\n" + counts + "\nWIDTH " + count + "\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS " + count +
         (points > 0 ? "\nDATA binary\n" : "\nDATA ascii\n");
}

/// PCL's packed colour.
std::uint32_t pcl_rgb(std::uint8_t red, std::uint8_t green, std::uint8_t blue) {
  return 0xff000000U | std::uint32_t{red} << 16U | std::uint32_t{green} << 8U | blue;
}

}  // namespace

std::string cloud_ply(const ColouredCloud& cloud) {
  const bool has_normals = cloud.size() > 0 && cloud.normals.size() == cloud.size();
  std::string bytes = ply_header(
      cloud.size(), position_properties + (has_normals ? normal_properties : "") + colour_properties);
  bytes.reserve(bytes.size() + cloud.size() * (has_normals ? 27 : 15));
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    put(bytes, cloud.points[i]);
    if (has_normals) {
      const Eigen::Vector3f& normal = cloud.normals[i];
      put(bytes, normal.allFinite() ? normal : Eigen::Vector3f::Zero().eval());
    }
    for (const int channel : {2, 1, 0}) put(bytes, cloud.colours[i][channel]);
  }
  return bytes;
}

void save_ply(const FilePlace& file, const ColouredCloud& cloud) {
  write_atomically(file, cloud_ply(cloud));
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

  std::string bytes = ply_header(landmarks.size(), properties);
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

void save_pcd(const FilePlace& file, const ColouredCloud& cloud) {
  const bool has_normals = cloud.size() > 0 && cloud.normals.size() == cloud.size();
  std::vector<PcdField> fields = {{"x", 'F'}, {"y", 'F'}, {"z", 'F'}, {"rgb", 'U'}};
  if (has_normals)
    for (const char* name : {"normal_x", "normal_y", "normal_z", "curvature"}) fields.push_back({name, 'F'});
  std::string bytes = pcd_header(cloud.size(), fields);
  bytes.reserve(bytes.size() + 4 * fields.size() * cloud.size());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const cv::Vec3b& bgr = cloud.colours[i];
    put(bytes, cloud.points[i]);
    put(bytes, pcl_rgb(bgr[2], bgr[1], bgr[0]));
    if (!has_normals) continue;
    put(bytes, cloud.normals[i]);
    put(bytes, 0.F);
  }
  write_atomically(file, bytes);
}

void save_pcd(const FilePlace& file, const std::vector<Landmark>& landmarks) {
  std::string bytes =
      pcd_header(landmarks.size(), {{"x", 'F'}, {"y", 'F'}, {"z", 'F'}, {"rgba", 'U'}, {"label", 'U'}});
  for (const Landmark& landmark : landmarks) {
    put(bytes, landmark.mean.cast<float>().eval());
    put(bytes, pcl_rgb(landmark.colour[0], landmark.colour[1], landmark.colour[2]));
    put(bytes, static_cast<std::uint32_t>(landmark.id));
  }
  write_atomically(file, bytes);
}

}  // namespace lcmslam
