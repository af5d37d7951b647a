#include <algorithm>
#include <cmath>

#include <lcmslam/imaging/depth_filter_parts.hpp>
#include <lcmslam/parallel/instruction_set.hpp>

namespace lcmslam {
namespace {

constexpr int near_reach = 2, far_reach = 4;  // pixels from the judged one, to see the side's slope
static_assert(far_reach <= DepthImage::border);
constexpr int piece = 32;  // pixels of a row that are judged together

// Standard deviations of the prediction's error, in those of a plain difference (sqrt 2 sigma):
// p = a + (a - b) / 3 has (4/3)^2 + (1/3)^2 + 1 sigma^2, p = a + (a - b) has 2^2 + 1 + 1.
constexpr float far_spread = 1.20f, near_spread = 1.73f;
constexpr float unseen_slope = 0.5f;  // standard deviations of a slope that are taken for noise

/// Limits of one pixel: what noise allows between it and a neighbour, slopes a pixel.
struct Limits {
  float noise, slope_noise, free_slope, steepest;
};

/// 1 where the surface goes on from q to its neighbour a, whose own side shows its slope at b or c.
inline int goes_on(float q, const Limits& limit, float a, float b, float c) {
  const float slope = c > 0 ? (a - c) * (1.0f / 3) : b > 0 ? a - b : 0.0f;
  const float noise_share = c > 0 ? 1.0f / 3 : 1.0f;
  const float spread = c > 0 ? far_spread : b > 0 ? near_spread : 1.0f;
  const float seen =
      std::min(std::max(std::abs(slope) - noise_share * limit.slope_noise, 0.0f), limit.steepest);
  const float step = q - a;
  const float rest = std::abs(step - (slope < 0 ? -seen : seen));
  const int flat = std::abs(step) <= limit.noise + limit.free_slope;
  const int inclined = rest <= spread * limit.noise;
  return (a > 0) & (flat | inclined);
}

struct RowSettings {
  float noise, slope_noise;          // times sigma
  float free_slope_x, free_slope_y;  // times q
  float steepest_x, steepest_y;      // times q
};

/// 1 where the surface goes on from q to its neighbour a as noise and a free slope allow, whatever its own
/// is.
inline int is_flat(float q, float allowed, float a) {
  return (a > 0) & (std::abs(q - a) <= allowed);
}

/// Whether each of `columns` pixels is kept at once, as most are: it goes on flatly along both axes, or there
/// is nothing to keep.
LCMSLAM_VECTORISED(all_flat,
                   (const float* const rows[2 * far_reach + 1], const float* sigma, int columns,
                    const RowSettings& settings, bool& all),
                   (rows, sigma, columns, settings, all)) {
  const float *row = rows[far_reach], *above = rows[far_reach - 1], *below = rows[far_reach + 1];
  const float noise_sigmas = settings.noise, slope_x = settings.free_slope_x, slope_y = settings.free_slope_y;
  int kept = 1;
  for (int u = 0; u < columns; ++u) {
    const float q = row[u], noise = noise_sigmas * sigma[u];
    const float allowed_x = noise + slope_x * q, allowed_y = noise + slope_y * q;
    const int sideways = is_flat(q, allowed_x, row[u - 1]) | is_flat(q, allowed_x, row[u + 1]);
    const int upright = is_flat(q, allowed_y, above[u]) | is_flat(q, allowed_y, below[u]);
    kept &= (sideways & upright) | (q == 0);
  }
  all = kept != 0;
}

/// Sets keep[u] to 0 where a measured pixel's surface ends on both sides across some edge.
LCMSLAM_VECTORISED(judge_row,
                   (const float* const rows[2 * far_reach + 1], const float* sigma, int columns,
                    const RowSettings& settings, std::int32_t* keep),
                   (rows, sigma, columns, settings, keep)) {
  const float* row = rows[far_reach];
  const float *up1 = rows[far_reach - 1], *up2 = rows[far_reach - near_reach], *up4 = rows[0];
  const float *down1 = rows[far_reach + 1], *down2 = rows[far_reach + near_reach],
              *down4 = rows[2 * far_reach];
  for (int u = 0; u < columns; ++u) {
    const float q = row[u];
    const Limits x = {settings.noise * sigma[u], settings.slope_noise * sigma[u], settings.free_slope_x * q,
                      settings.steepest_x * q};
    const Limits y = {x.noise, x.slope_noise, settings.free_slope_y * q, settings.steepest_y * q};
    const float left = row[u - 1], right = row[u + 1], up = up1[u], down = down1[u];
    const int sideways = goes_on(q, x, left, row[u - near_reach], row[u - far_reach]) |
                         goes_on(q, x, right, row[u + near_reach], row[u + far_reach]) |
                         ((left == 0) & (right == 0));
    const int upright = goes_on(q, y, up, up2[u], up4[u]) | goes_on(q, y, down, down2[u], down4[u]) |
                        ((up == 0) & (down == 0));
    keep[u] = sideways & upright;
  }
}

class JumpEdgeFilter : public DepthFilterPart {
 public:
  explicit JumpEdgeFilter(const JumpEdgeFilterSettings& settings) : settings_(settings) {}

  void apply(DepthImage& image) override {
    const auto free = static_cast<float>(std::tan(settings_.free_incidence));
    const auto steepest = static_cast<float>(std::tan(settings_.max_incidence));
    const auto root2 = static_cast<float>(std::sqrt(2.0));
    const RowSettings row_settings = {static_cast<float>(settings_.noise_sigmas) * root2,
                                      unseen_slope * root2,
                                      free * image.pitch_x,
                                      free * image.pitch_y,
                                      steepest * image.pitch_x,
                                      steepest * image.pitch_y};
    const cv::Size size = image.depth.size();
    keep_.create(far_reach + 1, size.width);
    // A row is judged by its neighbours as they were: what goes, goes when nobody looks at it any more.
    for (int v = 0; v < size.height + far_reach; ++v) {
      if (v < size.height) {
        const float* rows[2 * far_reach + 1];
        for (int j = -far_reach; j <= far_reach; ++j) rows[j + far_reach] = image.inverse_row(v + j);
        for (int u = 0; u < size.width; u += piece) {
          const int columns = std::min(piece, size.width - u);
          bool all = false;
          all_flat(rows, image.sigma_row(v) + u, columns, row_settings, all);
          if (all)
            std::fill_n(kept(v) + u, columns, 1);
          else
            judge_row(rows, image.sigma_row(v) + u, columns, row_settings, kept(v) + u);
          for (const float*& row : rows) row += columns;
        }
      }
      if (v >= far_reach) remove(v - far_reach, image);
    }
  }

 private:
  std::int32_t* kept(int v) { return keep_.ptr<std::int32_t>(v % (far_reach + 1)); }

  void remove(int v, DepthImage& image) {
    const std::int32_t* keep = kept(v);
    auto* depth = image.depth.ptr<std::uint16_t>(v);
    float* inverse = image.inverse_row(v);
    for (int u = 0; u < image.depth.cols; ++u) {
      depth[u] = static_cast<std::uint16_t>(depth[u] & -keep[u]);
      inverse[u] = keep[u] != 0 ? inverse[u] : 0.0f;
    }
  }

  JumpEdgeFilterSettings settings_;
  cv::Mat_<std::int32_t> keep_;  // of the newest rows
};

}  // namespace

std::unique_ptr<DepthFilterPart> make_jump_edge_filter(const JumpEdgeFilterSettings& settings) {
  return std::make_unique<JumpEdgeFilter>(settings);
}

}  // namespace lcmslam
