#pragma once
// What may happen to a camera's images, for experiments on robustness. All keep their sizes and stamps.

#include "tools/study/report/drive.hpp"

namespace lcmslam {

/// So much light as was there, 1: unchanged. Depth cameras bring their own.
ImageChange dimmed(double factor);

/// Texture that is left, 1: all of it. Each pixel comes nearer to the mean of those within 12 pixels, so that
/// large shapes stay.
ImageChange smoothed(double left);

/// The light (or the exposure) swings by so many stops up and down within 3 s; what is too bright saturates.
ImageChange flickering(double stops);

/// A person, a textured pillar of 0.25 m radius and 1.75 m height, crosses 2 m ahead of the robot from left
/// to right and back at 0.8 m/s, all the time, before whatever stands there. Not for lenses that roll.
ImageChange with_person(const Drive& drive);

}  // namespace lcmslam
