#include <lcmslam/calibration/self/drive_advice.hpp>

#include <cmath>
#include <cstdio>

namespace lcmslam {
namespace {

/// Something of one or three axes, and how sure it is: standard deviations of all axes together.
struct Accuracy {
  std::string name, limit, command;  // the command that finds it with a board
  int axes = 1;
  double wanted = 0, sigma = 0, stays = 0;
};

/// That a normal error of so many axes, all alike, is smaller: Maxwell's distribution for three.
double probability(const Accuracy& a, double sigma) {
  const double k = a.wanted * std::sqrt(a.axes) / sigma;
  const double one = std::erf(M_SQRT1_2 * k);
  return a.axes == 1 ? one : one - std::sqrt(2 / M_PI) * k * std::exp(-0.5 * k * k);
}

double sigma_with(const Accuracy& a, double share_of_keyframes) {
  const double shrinks = std::max(0.0, a.sigma * a.sigma - a.stays * a.stays);
  return std::sqrt(a.stays * a.stays + shrinks / share_of_keyframes);
}

double length(const HeadNumbers& n, head::Parameter first) {
  return std::sqrt(n[first] * n[first] + n[first + 1] * n[first + 1] + n[first + 2] * n[first + 2]);
}

std::vector<Accuracy> accuracies(const HeadModel& model, const BundleResult& result,
                                 const WantedAccuracy& wanted) {
  const HeadNumbers stays = unmodelled_sigmas(model.start);
  const double f = model.colour().fx;
  std::vector<Accuracy> all = {{"the focal length", "0.3 %", "camera", 1, wanted.focal,
                                result.sigmas[head::fx] / f, stays[head::fx] / f}};
  if (model.registered()) return all;
  const double by_scale = result.sigmas[head::depth_scale] * model.T_colour_depth().translation().norm();
  all.push_back({"the depth camera's place", "2 mm", "pair", 3, wanted.translation,
                 length(result.sigmas, head::tx), std::hypot(length(stays, head::tx), by_scale)});
  all.push_back({"the depth camera's direction", "0.1 degrees", "pair", 3, wanted.rotation,
                 length(result.sigmas, head::rx), length(stays, head::rx)});
  return all;
}

}  // namespace

std::vector<std::string> drive_advice(const HeadModel& model, const BundleResult& result,
                                      std::size_t keyframes, std::size_t most, const WantedAccuracy& wanted) {
  const double longest = static_cast<double>(most) / static_cast<double>(keyframes);
  std::vector<std::string> advice;
  for (const Accuracy& a : accuracies(model, result, wanted)) {
    if (result.held(a.axes == 1 ? head::fx : head::tx) || probability(a, a.sigma) >= wanted.probability)
      continue;
    double share = 1;
    while (share <= longest && probability(a, sigma_with(a, share)) < wanted.probability) share += 0.1;
    char help[160];
    std::snprintf(help, sizeof help, "no longer drive tells enough: calibrate %s does, with a board",
                  a.command.c_str());
    if (share <= longest)
      std::snprintf(help, sizeof help,
                    "drive until there are some %.0f keyframes (%zu now), one each 12 cm or 7 degrees",
                    std::ceil(share * static_cast<double>(keyframes)), keyframes);
    char text[400];
    std::snprintf(text, sizeof text, "%s is within %s with a probability of %.0f %% (%.0f %% is wanted): %s",
                  a.name.c_str(), a.limit.c_str(), 100 * probability(a, a.sigma), 100 * wanted.probability,
                  help);
    advice.emplace_back(text);
  }
  return advice;
}

std::vector<std::string> self_doubts(const BundleResult& result, const BundleSettings& settings,
                                     std::size_t keyframes) {
  // A sixth of what is asked for: of fewer, what a few of them err by alike looks like the head.
  constexpr std::size_t fewest = 20, good = 120;
  std::vector<std::string> doubts;
  if (keyframes < fewest)
    doubts.push_back("only " + std::to_string(keyframes) + " keyframes: drive until there are some " +
                     std::to_string(good) + ", " + std::to_string(fewest) + " at least");
  bool tells = false;
  for (int p = 0; p < head::count; ++p)
    tells = tells || is_observed(result, static_cast<head::Parameter>(p), settings);
  if (!tells)
    doubts.emplace_back(
        "the recording tells nothing of the head that the start does not say: move and turn more");
  return doubts;
}

}  // namespace lcmslam
