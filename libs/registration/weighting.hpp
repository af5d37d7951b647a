#pragma once
// How much a pair counts: its noise and a robust kernel.

#include <memory>

#include <lcmslam/registration/metric.hpp>

namespace lcmslam {

/// Weight w(s) of a residual of s standard deviations (iteratively reweighted least squares).
class RobustKernel {
 public:
  virtual ~RobustKernel() = default;
  virtual double weight(double squared_sigmas) const = 0;
};

class NoKernel : public RobustKernel {
 public:
  double weight(double) const override { return 1; }
};

/// 1 within the width, width / s beyond.
class HuberKernel : public RobustKernel {
 public:
  explicit HuberKernel(double width) : width_(width) {}
  double weight(double squared_sigmas) const override;

 private:
  double width_;
};

/// (1 + s^2 / width^2)^-2.
class GemanMcClureKernel : public RobustKernel {
 public:
  explicit GemanMcClureKernel(double width) : squared_width_(width * width) {}
  double weight(double squared_sigmas) const override;

 private:
  double squared_width_;
};

std::unique_ptr<RobustKernel> make_kernel(const RegistrationSettings& settings);

/// Sets all weights. The kernel's unit is the pairs' own spread while that is larger than the noise
/// (1.4826 x the median of |r| / sigma), so that a poor start does not make every pair an outlier.
/// `settled_lead`: young surfaces lead only where there are no others.
void weigh_pairs(std::vector<Pair>& pairs, const Metric& metric, const RobustKernel& kernel,
                 bool weigh_by_noise, bool settled_lead = false);

}  // namespace lcmslam
