// Finds bright discs on a dark image where they were drawn.

#include <cmath>
#include <iostream>
#include <opencv2/imgproc.hpp>

#include <lcmslam/surf/surf.hpp>

int main() {
  const cv::Point discs[] = {{60, 50}, {150, 70}, {250, 60}, {90, 170}, {230, 180}};
  cv::Mat image(240, 320, CV_8UC1, cv::Scalar(40));
  for (const cv::Point& centre : discs)
    cv::circle(image, centre, 8, cv::Scalar(220), cv::FILLED, cv::LINE_AA);

  lcmslam::Surf surf;
  std::vector<cv::KeyPoint> keypoints;
  cv::Mat descriptors;
  surf.detectAndCompute(image, cv::noArray(), keypoints, descriptors);

  for (const cv::Point& centre : discs) {
    bool found = false;
    for (const cv::KeyPoint& k : keypoints)
      found |= std::hypot(k.pt.x - centre.x, k.pt.y - centre.y) < 1 && k.class_id == -1;
    if (!found) {
      std::cerr << "no bright blob at " << centre << "\n";
      return 1;
    }
  }
  if (descriptors.rows != int(keypoints.size()) || descriptors.cols != 64) return 1;
  for (int i = 0; i < descriptors.rows; ++i)
    if (std::abs(cv::norm(descriptors.row(i)) - 1) > 1e-5) return 1;
  std::cout << keypoints.size() << " keypoints\n";
  return 0;
}
