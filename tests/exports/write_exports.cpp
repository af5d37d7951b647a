// write_exports FOLDER: a small map in every format, as a program writes it that has taken its user's locale,
// and expected.json, which says what others must read.

#include <nlohmann/json.hpp>

#include <clocale>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <locale>

#include "tests/exports/sample_exports.hpp"

using namespace lcmslam;
using nlohmann::json;

namespace {

constexpr int skipped = 77;

template <class Vector>
json numbers(const Vector& vector) {
  json values = json::array();
  for (int i = 0; i < static_cast<int>(vector.size()); ++i) values.push_back(vector[i]);
  return values;
}

template <class Vectors>
json rows(const Vectors& vectors) {
  json values = json::array();
  for (const auto& vector : vectors) values.push_back(numbers(vector));
  return values;
}

json rgb(const std::vector<cv::Vec3b>& colours) {
  json values = json::array();
  for (const cv::Vec3b& c : colours) values.push_back({c[2], c[1], c[0]});
  return values;
}

json expected(const SampleMap& map) {
  json triangles, landmarks, poses;
  for (const auto& triangle : map.mesh.triangles) triangles.push_back(triangle);
  for (const Landmark& l : map.landmarks)
    landmarks.push_back({{"id", l.id}, {"mean", numbers(l.mean)}, {"log_odds", l.log_odds}});
  for (const StampedPose& pose : map.trajectory) {
    json matrix = json::array();
    for (int i = 0; i < 16; ++i) matrix.push_back(pose.T_world_body.matrix()(i / 4, i % 4));
    poses.push_back({{"utime", pose.utime}, {"matrix", matrix}});
  }
  return {{"mesh",
           {{"vertices", rows(map.mesh.vertices)},
            {"normals", rows(map.mesh.normals)},
            {"colours", rgb(map.mesh.colours)},
            {"triangles", triangles}}},
          {"cloud",
           {{"points", rows(map.cloud.points)},
            {"normals", rows(map.cloud.normals)},
            {"colours", rgb(map.cloud.colours)}}},
          {"landmarks", landmarks},
          {"trajectory", poses}};
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2 && argc != 3) {
    std::cerr << "usage: write_exports FOLDER [DECIMAL_POINT]\n";
    return 2;
  }
  try {
    std::locale::global(std::locale(""));  // C's as well
  } catch (const std::runtime_error&) {
    const char* const name = std::getenv("LC_ALL");
    std::cout << "skipped: no locale '" << (name != nullptr ? name : "")
              << "' here; ./lcmslam test installs the package locales, from which it is made\n";
    return skipped;
  }
  if (argc == 3 && std::string(std::localeconv()->decimal_point) != argv[2]) {
    std::cerr << "the locale's decimal point is '" << std::localeconv()->decimal_point << "', not '"
              << argv[2] << "': nothing would be tested\n";
    return 1;
  }
  const std::filesystem::path folder = argv[1];
  std::filesystem::create_directories(folder);
  const SampleMap map;
  save_exports(folder, map);
  std::ofstream(folder / "expected.json") << expected(map) << '\n';
}
