#pragma once
// The materials of a scene's file: painted once, and taken by name.

#include <map>
#include <string>
#include <vector>

#include <lcmslam/simulation/painter.hpp>
#include <lcmslam/simulation/scene.hpp>
#include <lcmslam/simulation/shapes.hpp>

namespace lcmslam {

class SceneMaterials {
 public:
  /// What is read is added to `materials`, which must outlive this.
  explicit SceneMaterials(std::vector<SceneMaterial>& materials) : materials_(materials) {}

  /// One of the file's materials, with all its variants. Throws ConfigError.
  void read(const ConfigNode& node);
  /// What an object's key names, or `fallback`: of several variants each object takes the next. Throws
  /// ConfigError.
  FaceMaterial of(const ConfigNode& node, const std::string& key, const std::string& fallback);

 private:
  void add_picture(const std::string& name, const std::string& kind, const PaintSettings& paint, int seed,
                   double infrared, const FaceMaterial& face);

  struct Variants {
    std::vector<FaceMaterial> faces;
    std::size_t next = 0;
  };
  std::vector<SceneMaterial>& materials_;
  std::map<std::string, Variants> by_name_;
};

}  // namespace lcmslam
