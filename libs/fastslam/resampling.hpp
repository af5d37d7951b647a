#pragma once
// Resampling: indices of particles drawn with replacement so that particle i is expected
// n * weight_i times. The schemes differ in variance (Douc, Cappe, Moulines 2005).

#include <vector>

#include <lcmslam/fastslam/settings.hpp>
#include <lcmslam/geometry/random.hpp>

namespace lcmslam {

/// As many ancestors as weights, ascending. Weights are normalised: non-negative, sum 1.
std::vector<int> resample(const std::vector<double>& weights, ResamplingScheme scheme, Random& random);

/// 1 / sum w_i^2 of normalised weights (Kong, Liu, Wong 1994): 1 .. n.
double effective_sample_size(const std::vector<double>& weights);

/// exp(log_weights), normalised; equal weights when none is finite.
std::vector<double> normalised_weights(const std::vector<double>& log_weights);

}  // namespace lcmslam
