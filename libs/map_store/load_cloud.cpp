// What goes through PCL: PCD files, and reading back.

#include <pcl/PCLPointCloud2.h>
#include <pcl/conversions.h>
#include <pcl/io/pcd_io.h>
#include <pcl/io/ply_io.h>
#include <pcl/point_types.h>

#include <algorithm>
#include <fstream>
#include <set>
#include <stdexcept>

#include <lcmslam/cloud/coloured_cloud.hpp>
#include <lcmslam/files/atomic_file.hpp>
#include <lcmslam/map_store/map_export.hpp>

namespace lcmslam {
namespace {

namespace fs = std::filesystem;

template <class Point>
void put(Point& target, const Eigen::Vector3f& position, const std::uint8_t red, const std::uint8_t green,
         const std::uint8_t blue) {
  target.getVector3fMap() = position;
  target.r = red;
  target.g = green;
  target.b = blue;
}

/// PCL's writers refuse an empty cloud.
const char* const empty_pcd =
    "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z rgb\nSIZE 4 4 4 4\nTYPE F F F F\n"
    "COUNT 1 1 1 1\nWIDTH 0\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 0\nDATA ascii\n";

template <class Point>
void save(const FilePlace& file, const pcl::PointCloud<Point>& cloud) {
  if (cloud.empty()) {
    write_atomically(file, std::string(empty_pcd));
    return;
  }
  write_atomically(file, [&](const fs::path& part) {
    // The writer for the point type: the one for PCLPointCloud2 miscounts padding between fields.
    if (pcl::PCDWriter().writeBinary(part.string(), cloud) < 0)
      throw std::runtime_error("PCL could not write it (disk full?)");
  });
}

template <class Point>
pcl::PointCloud<Point> positions_and_colours(const ColouredCloud& cloud) {
  pcl::PointCloud<Point> points(static_cast<std::uint32_t>(cloud.size()), 1);
  points.is_dense = true;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const cv::Vec3b& bgr = cloud.colours[i];
    put(points[i], cloud.points[i], bgr[2], bgr[1], bgr[0]);
  }
  return points;
}

bool has_field(const pcl::PCLPointCloud2& cloud, const std::string& name) {
  return std::any_of(cloud.fields.begin(), cloud.fields.end(),
                     [&](const pcl::PCLPointField& field) { return field.name == name; });
}

/// PCL prints a warning for each field of Point that a file has not: ask for those that it has.
template <class Point>
pcl::PointCloud<Point> fields_of(const pcl::PCLPointCloud2& generic) {
  pcl::PointCloud<Point> points;
  pcl::fromPCLPointCloud2(generic, points);
  return points;
}

ColouredCloud from_pcl(const pcl::PCLPointCloud2& generic, const fs::path& file) {
  for (const char* axis : {"x", "y", "z"})
    if (!has_field(generic, axis))
      throw std::runtime_error("cannot read " + file.string() + ": has no field '" + axis + "'");
  ColouredCloud cloud;
  if (generic.width * generic.height == 0) return cloud;
  for (const auto& point : fields_of<pcl::PointXYZ>(generic)) cloud.points.push_back(point.getVector3fMap());
  cloud.colours.resize(cloud.points.size());
  if (has_field(generic, "rgb") || has_field(generic, "rgba")) {
    const auto points = fields_of<pcl::PointXYZRGB>(generic);
    for (std::size_t i = 0; i < points.size(); ++i)
      cloud.colours[i] = cv::Vec3b(points[i].b, points[i].g, points[i].r);
  }
  if (has_field(generic, "normal_x") && has_field(generic, "normal_y") && has_field(generic, "normal_z"))
    for (const auto& point : fields_of<pcl::Axis>(generic))
      cloud.normals.push_back(point.getNormalVector3fMap());
  return cloud;
}

/// PCL's reader does not come back from a file without these lines.
void check_pcd_header(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  std::set<std::string> missing = {"FIELDS", "SIZE", "TYPE", "WIDTH", "HEIGHT", "POINTS", "DATA"};
  std::string line;
  for (int lines = 0; lines < 100 && missing.count("DATA") && std::getline(stream, line); ++lines)
    missing.erase(line.substr(0, line.find(' ')));
  if (!missing.empty())
    throw std::runtime_error("cannot read " + file.string() + ": no PCD file, it has no line " +
                             *missing.begin());
}

/// PCL's reader prints about a file without it.
void check_ply_header(const fs::path& file) {
  std::string line;
  std::getline(std::ifstream(file, std::ios::binary), line);
  if (line != "ply" && line != "ply\r")
    throw std::runtime_error("cannot read " + file.string() + ": no PLY file, its first line is not 'ply'");
}

template <class Reader>
ColouredCloud load(const fs::path& file) {
  if (!fs::is_regular_file(file)) throw std::runtime_error("cannot read " + file.string() + ": no such file");
  pcl::PCLPointCloud2 generic;
  int result = -1;
  try {
    Reader reader;
    result = reader.read(file.string(), generic);
  } catch (const std::exception& error) {
    throw std::runtime_error("cannot read " + file.string() + ": " + error.what());
  }
  if (result < 0) throw std::runtime_error("cannot read " + file.string() + ": not a valid point cloud file");
  return from_pcl(generic, file);
}

}  // namespace

void save_pcd(const FilePlace& file, const ColouredCloud& cloud) {
  if (cloud.normals.empty() || cloud.normals.size() != cloud.size()) {
    save(file, positions_and_colours<pcl::PointXYZRGB>(cloud));
    return;
  }
  auto points = positions_and_colours<pcl::PointXYZRGBNormal>(cloud);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    points[i].getNormalVector3fMap() = cloud.normals[i];
    points[i].curvature = 0;
  }
  save(file, points);
}

void save_pcd(const FilePlace& file, const std::vector<Landmark>& landmarks) {
  pcl::PointCloud<pcl::PointXYZRGBL> points(static_cast<std::uint32_t>(landmarks.size()), 1);
  points.is_dense = true;
  for (std::size_t i = 0; i < landmarks.size(); ++i) {
    const Landmark& landmark = landmarks[i];
    put(points[i], landmark.mean.cast<float>(), landmark.colour[0], landmark.colour[1], landmark.colour[2]);
    points[i].label = static_cast<std::uint32_t>(landmark.id);
  }
  save(file, points);
}

ColouredCloud load_ply(const fs::path& file) {
  if (fs::is_regular_file(file)) check_ply_header(file);
  return load<pcl::PLYReader>(file);
}

ColouredCloud load_pcd(const fs::path& file) {
  if (fs::is_regular_file(file)) check_pcd_header(file);
  return load<pcl::PCDReader>(file);
}

}  // namespace lcmslam
