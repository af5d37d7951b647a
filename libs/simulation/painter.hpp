#pragma once
// Procedural pictures for the scenes' surfaces. All are drawn from a seeded generator: the same
// material is the same picture on every machine.

#include <map>
#include <opencv2/core.hpp>
#include <string>

#include <lcmslam/geometry/random.hpp>

namespace lcmslam {

struct PaintSettings {
  cv::Scalar colour;       ///< BGR, 0..255
  cv::Scalar accent;       ///< BGR, of grout, drawings, handles
  double texel = 0.003;    ///< m
  double cell = 0.15;      ///< m, of tiles, planks, books, drawings
  double variation = 0.1;  ///< 0..1, difference between cells
  std::string text;        ///< of posters and labels
};

/// Paints the canvas (CV_8UC3, already filled with settings.colour).
using Painter = void (*)(cv::Mat& canvas, const PaintSettings& settings, Random& random);

/// plain, speckle, tiles, wood, poster, label, door, oven, books, carpet.
const std::map<std::string, Painter>& painters();

/// Multiplies colours by smooth random factors about 1: `scale` pixels wide, `strength` strong.
void shade_randomly(cv::Mat& canvas, int scale, double strength, Random& random);

}  // namespace lcmslam
