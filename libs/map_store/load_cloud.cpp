// Clouds are read through PCL, which knows every kind of PCD and PLY.

#include <pcl/PCLPointCloud2.h>
#include <pcl/console/print.h>
#include <pcl/conversions.h>
#include <pcl/io/pcd_io.h>
#include <pcl/io/ply_io.h>
#include <pcl/point_types.h>

#include <algorithm>
#include <fstream>
#include <set>
#include <stdexcept>

#include <lcmslam/cloud/coloured_cloud.hpp>
#include <lcmslam/map_store/map_export.hpp>

namespace lcmslam {
namespace {

namespace fs = std::filesystem;

/// PCL prints about what it reads: our errors say it.
class SilentPcl {
 public:
  SilentPcl() { pcl::console::setVerbosityLevel(pcl::console::L_ALWAYS); }
  ~SilentPcl() { pcl::console::setVerbosityLevel(before_); }
  SilentPcl(const SilentPcl&) = delete;
  SilentPcl& operator=(const SilentPcl&) = delete;

 private:
  pcl::console::VERBOSITY_LEVEL before_ = pcl::console::getVerbosityLevel();
};

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

void check_ply_header(const fs::path& file) {
  std::string line;
  std::getline(std::ifstream(file, std::ios::binary), line);
  if (line != "ply" && line != "ply\r")
    throw std::runtime_error("cannot read " + file.string() + ": no PLY file, its first line is not 'ply'");
}

void check_file(const fs::path& file) {
  if (!fs::is_regular_file(file)) throw std::runtime_error("cannot read " + file.string() + ": no such file");
  if (fs::is_empty(file)) throw std::runtime_error("cannot read " + file.string() + ": is empty");
}

template <class Reader>
ColouredCloud load(const fs::path& file) {
  const SilentPcl silent;
  pcl::PCLPointCloud2 generic;
  int result = -1;
  try {
    Reader reader;
    result = reader.read(file.string(), generic);
  } catch (const std::exception& error) {
    throw std::runtime_error("cannot read " + file.string() + ": " + error.what());
  }
  if (result < 0)
    throw std::runtime_error("cannot read " + file.string() +
                             ": its points are not what its header says (damaged, or cut off)");
  return from_pcl(generic, file);
}

}  // namespace

ColouredCloud load_ply(const fs::path& file) {
  check_file(file);
  check_ply_header(file);
  return load<pcl::PLYReader>(file);
}

ColouredCloud load_pcd(const fs::path& file) {
  check_file(file);
  check_pcd_header(file);
  return load<pcl::PCDReader>(file);
}

}  // namespace lcmslam
