#pragma once
// Which part of a source image the target image shows too, from colour alone (thesis section 3.4.1, step 1
// of algorithm 3.2): the source is cut into segments, each is looked for in the target by the normalised
// correlation coefficient (eq. 3.3; cv::TM_CCOEFF_NORMED).

#include <opencv2/core.hpp>

#include <lcmslam/registration/image_overlap.hpp>
#include <lcmslam/settings/settings.hpp>

namespace lcmslam {

struct ColourOverlapSettings {
  int columns = 8, rows = 6;
  double scale = 0.25;
  double threshold = 0.7;
  double min_contrast = 4;
  double search = 0;

  void describe(SettingsVisitor& s) {
    s.number("columns", columns, "", {1, 1000}, "segments of the image from left to right");
    s.number("rows", rows, "", {1, 1000}, "segments of the image from top to bottom");
    s.number("scale", scale, "", {0.01, 1},
             "of both images, in which is searched: at full size it takes seconds");
    s.number("threshold", threshold, "", {-1, 1}, "coefficient from which on a segment is found again");
    s.number("min_contrast", min_contrast, "grey values", {0, 255},
             "standard deviation; plainer segments have no coefficient");
    s.number("search", search, "pixels", {0, 10000},
             "at full size, around the expected place; 0: everywhere");
  }
};

/// `source` and `target`: CV_8UC1 or CV_8UC3 of one size. Segments are expected where `shift` (pixels) moves
/// them, when only around there is searched. Throws std::invalid_argument for images that do not fit together
/// and settings out of range.
ImageOverlap colour_overlap(const cv::Mat& source, const cv::Mat& target,
                            const ColourOverlapSettings& settings = {}, const cv::Point2d& shift = {});

}  // namespace lcmslam
