#include <lcmslam/simulation/scene_materials.hpp>

#include <algorithm>
#include <opencv2/imgproc.hpp>

namespace lcmslam {
namespace {

cv::Scalar colour(const ConfigNode& config, const std::string& key, const std::vector<double>& fallback) {
  const std::vector<double> rgb = config.get(key, fallback);
  if (rgb.size() != 3) config.fail(key, "must be three numbers 0..255: red, green, blue");
  for (const double value : rgb)
    if (!(value >= 0 && value <= 255)) config.fail(key, "must be three numbers 0..255: red, green, blue");
  return {rgb[2], rgb[1], rgb[0]};
}

}  // namespace

void SceneMaterials::read(const ConfigNode& node) {
  std::vector<std::string> kinds;
  for (const auto& [kind, painter] : painters()) kinds.push_back(kind);
  const std::string name = node.text("name"), kind = node.choice("kind", "plain", kinds);
  PaintSettings paint;
  paint.colour = colour(node, "colour", {200, 200, 200});
  paint.accent = colour(node, "accent", {60, 60, 60});
  paint.texel = node.get("texel", 0.003, {0.0005, 0.1});
  paint.cell = node.get("cell", 0.15, {0.005, 10});
  paint.variation = node.get("variation", 0.1, {0, 1});
  paint.text = node.get("text", "");
  const double infrared = node.get("infrared", -1.0, {-1, 1});
  const std::vector<double> size = node.has("size") ? node.numbers("size", 2) : std::vector<double>{1.2, 1.2};
  if (!(size[0] >= 0.01 && size[1] >= 0.01 && size[0] <= 20 && size[1] <= 20))
    node.fail("size", "must be two lengths from 0.01 to 20 m");

  const double texels = size[0] * size[1] / (paint.texel * paint.texel);
  if (texels > 16e6)
    node.fail("texel", "makes more than 16 million texels; use a larger texel or a smaller size");
  FaceMaterial face;
  face.fitted = node.get("fitted", kind == "poster" || kind == "label" || kind == "door" || kind == "oven");
  face.texture_size = {static_cast<float>(size[0]), static_cast<float>(size[1])};
  if (by_name_.count(name)) node.fail("name", "material '" + name + "' is already defined");
  const int seed = node.get("seed", static_cast<int>(materials_.size()) + 1, {0, 1e9});
  const int variants = node.get("variants", 1, {1, 100});
  for (int variant = 0; variant < variants; ++variant) {
    add_picture(name, kind, paint, seed + 1000 * variant, infrared, face);
    std::rotate(&paint.colour[0], &paint.colour[1], &paint.colour[3]);  // other pictures, other colours
  }
}

void SceneMaterials::add_picture(const std::string& name, const std::string& kind, const PaintSettings& paint,
                                 int seed, double infrared, const FaceMaterial& face) {
  const cv::Size pixels(std::max(1, static_cast<int>(face.texture_size.x() / paint.texel + 0.5)),
                        std::max(1, static_cast<int>(face.texture_size.y() / paint.texel + 0.5)));
  cv::Mat canvas(kind == "plain" ? cv::Size(1, 1) : pixels, CV_8UC3, paint.colour);
  Random random(static_cast<std::uint64_t>(seed));
  painters().at(kind)(canvas, paint, random);

  // Pigments differ less in the near infrared than in visible light.
  cv::Mat grey, bgri;
  cv::cvtColor(canvas, grey, cv::COLOR_BGR2GRAY);
  if (infrared >= 0)
    grey.setTo(infrared * 255);
  else
    grey.convertTo(grey, CV_8U, 0.6, 60);
  cv::merge(std::vector<cv::Mat>{canvas, grey}, bgri);

  FaceMaterial numbered = face;
  numbered.index = static_cast<std::uint16_t>(materials_.size());
  by_name_[name].faces.push_back(numbered);
  materials_.push_back({name, Texture(bgri, face.texture_size), kind == "plain"});
}

FaceMaterial SceneMaterials::of(const ConfigNode& node, const std::string& key, const std::string& fallback) {
  const std::string name = fallback.empty() ? node.text(key) : node.get(key, fallback);
  auto found = by_name_.find(name);
  if (found != by_name_.end()) {
    Variants& variants = found->second;
    return variants.faces[variants.next++ % variants.faces.size()];
  }
  std::string known;
  for (const auto& [other, face] : by_name_) known += (known.empty() ? "" : ", ") + other;
  node.fail(key, "no material is named '" + name + "'; there are: " + known);
}

}  // namespace lcmslam
