#pragma once
// What stands around and over a drawn map: grid, axes, scale bar, lines, dots, legend, title.

#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include <lcmslam/rendering/map_picture.hpp>
#include <lcmslam/rendering/view_camera.hpp>

namespace lcmslam {

struct PictureStyle {
  cv::Scalar background, grid, frame, text;
  double unit;  ///< scale of text and lines: 1 for a picture of 1200 rows
};
PictureStyle picture_style(const PictureRequest& request);

/// 1, 2 or 5 times a power of ten, at least `least`.
double round_step(double least);

/// Lines of constant world x and y through `height`, over the whole frame (top view).
void draw_top_grid(cv::Mat& picture, const ViewCamera& camera, const ViewFrame& frame,
                   const PictureStyle& style);
/// Blanks what lies outside the frame, then tick labels in m, frame and scale bar (top view).
void draw_top_axes(cv::Mat& picture, const ViewCamera& camera, const ViewFrame& frame,
                   const PictureStyle& style);
/// Tiles of 1 m on the ground under a sparse map (front view).
void draw_ground(cv::Mat& picture, const ViewCamera& camera, const std::vector<Eigen::Vector3d>& points,
                 const PictureStyle& style);

void draw_path(cv::Mat& picture, const ViewCamera& camera, const PicturePath& path,
               const PictureStyle& style);
/// Far ones first; radius by certainty.
void draw_landmarks(cv::Mat& picture, const ViewCamera& camera, const std::vector<Landmark>& landmarks,
                    const PictureStyle& style);

void draw_title_and_legend(cv::Mat& picture, const PictureRequest& request, const PictureStyle& style);
void draw_text(cv::Mat& picture, const std::string& text, cv::Point2d centre, double size,
               const PictureStyle& style);

}  // namespace lcmslam
