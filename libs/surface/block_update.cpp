#include <lcmslam/surface/block_update.hpp>

#include <algorithm>
#include <cstring>

#include <lcmslam/parallel/instruction_set.hpp>

namespace lcmslam {
namespace {

constexpr int slab = VoxelBlock::side * VoxelBlock::side;  // voxels of one z, worked on together

struct Slab {
  float x[slab], y[slab], z[slab];  // m, of the voxels
  std::int32_t pixel[slab];
  float plane[4 * slab], look[slab];   // of the pixels
  float distance[slab], weight[slab];  // as they are kept
  float near_weight[slab];             // of the colour
  // Whether any voxel has a weight, and one near the surface: whole numbers, because the greatest of
  // floating-point numbers is not vectorised.
  int weighed, near;
};

// Voxel centres and the pixels that see them.
LCMSLAM_VECTORISED(find_pixels,
                   (const float* first, const float* step_x, const float* step_y, const Lens& lens, Slab& s),
                   (first, step_x, step_y, lens, s)) {
  for (int i = 0; i < slab; ++i) {
    const auto column = static_cast<float>(i & 7), row = static_cast<float>(i >> 3);
    const float x = first[0] + column * step_x[0] + row * step_y[0];
    const float y = first[1] + column * step_x[1] + row * step_y[1];
    const float z = first[2] + column * step_x[2] + row * step_y[2];
    s.x[i] = x;
    s.y[i] = y;
    s.z[i] = z;
    s.pixel[i] = lens.pixel(x, y, z);
  }
}

/// Four numbers at a time: faster than the processor's own gathering of one number from eight places.
void fetch(const SurfaceView& view, Slab& s) {
  for (int i = 0; i < slab; ++i) {
    const auto pixel = static_cast<std::size_t>(s.pixel[i]);
    std::memcpy(s.plane + 4 * i, view.planes[pixel].data(), 4 * sizeof(float));
    s.look[i] = view.weight[pixel];
  }
}

// What the pixels say of the voxels.
LCMSLAM_VECTORISED(measure, (float truncation, float colour_reach, Slab& s), (truncation, colour_reach, s)) {
  const float to_kept = VoxelBlock::full_distance / truncation, to_fade = 2 / truncation;
  int weighed = 0, near = 0;
  for (int i = 0; i < slab; ++i) {
    const float* plane = s.plane + 4 * i;
    const float d = plane[0] * s.x[i] + plane[1] * s.y[i] + plane[2] * s.z[i] + plane[3];
    // The farther behind the surface, the less is known: the back of something thin has its own looks.
    const float behind = 2 + d * to_fade;
    const float fade = behind > 1 ? 1.0f : behind > 0 ? behind : 0.0f;
    const float w = static_cast<float>(static_cast<int>(s.look[i] * fade + 0.5f));
    s.distance[i] = (d < truncation ? d : truncation) * to_kept;
    s.weight[i] = w;
    const float near_weight = (d < colour_reach) & (d > -colour_reach) ? w : 0.0f;
    s.near_weight[i] = near_weight;
    weighed |= w > 0 ? 1 : 0;
    near |= near_weight > 0 ? 1 : 0;
  }
  s.weighed = weighed;
  s.near = near;
}

LCMSLAM_VECTORISED(average,
                   (const Slab& s, float sign, float most_weight, std::int16_t* distance,
                    std::uint16_t* weight),
                   (s, sign, most_weight, distance, weight)) {
  for (int i = 0; i < slab; ++i) {
    const auto old_weight = static_cast<float>(weight[i]);
    const float change = sign * s.weight[i];
    const float sum = old_weight + change;
    const float share = change / (sum > 1 ? sum : 1.0f);
    const auto old = static_cast<float>(distance[i]);
    float mean = old + (s.distance[i] - old) * share;
    mean = mean > VoxelBlock::full_distance ? VoxelBlock::full_distance : mean;
    mean = mean < -VoxelBlock::full_distance ? -VoxelBlock::full_distance : mean;
    mean = sum >= 1 ? mean : 0.0f;
    const float kept =
        sum > most_weight && sign > 0 ? (old_weight > most_weight ? old_weight : most_weight) : sum;
    distance[i] = static_cast<std::int16_t>(static_cast<int>(mean + (mean < 0 ? -0.5f : 0.5f)));
    weight[i] = static_cast<std::uint16_t>(static_cast<int>(kept > 0 ? kept : 0.0f));
  }
}

/// Few voxels are near the surface.
void colour_voxels(const SurfaceView& view, const Slab& s, bool taken_out, int first, VoxelBlock& block) {
  for (int i = 0; i < slab; ++i) {
    const auto pixel = static_cast<std::size_t>(s.pixel[i]);
    const std::array<std::uint8_t, 4>& seen = view.colours[pixel];
    const int look = seen[3];
    if (s.near_weight[i] <= 0 || look == 0) continue;
    const int voxel = first + i;
    const int sum = block.colour_weight[voxel] + (taken_out ? -look : look);
    block.colour_weight[voxel] =
        static_cast<std::uint8_t>(std::clamp(sum, 0, VoxelBlock::most_colour_weight));
    if (taken_out) continue;  // the looks that stay bring the mean back
    const float share = static_cast<float>(look) / static_cast<float>(sum);
    const auto mix = [&](std::uint8_t& old, std::uint8_t colour) {
      const float step = share * static_cast<float>(colour - old);
      old = static_cast<std::uint8_t>(old + static_cast<int>(step + (step < 0 ? -0.5f : 0.5f)));
    };
    mix(block.blue[voxel], seen[0]);
    mix(block.green[voxel], seen[1]);
    mix(block.red[voxel], seen[2]);
  }
}

}  // namespace

bool update_block(const SurfaceView& view, const BlockPlace& place, const LookSettings& settings,
                  VoxelBlock& block) {
  const float sign = settings.taken_out ? -1.0f : 1.0f;
  bool changed = false;
  Slab s;
  for (int z = 0; z < VoxelBlock::side; ++z) {
    const Eigen::Vector3f first = place.first + static_cast<float>(z) * place.step[2];
    find_pixels(first.data(), place.step[0].data(), place.step[1].data(), view.lens, s);
    int in_view = 0;
    for (int i = 0; i < slab; ++i) in_view |= s.pixel[i] ^ view.lens.nothing;
    if (in_view == 0) continue;
    fetch(view, s);
    measure(settings.truncation, settings.colour_reach, s);
    if (s.weighed == 0) continue;
    changed = true;
    const int voxel = slab * z;
    average(s, sign, settings.most_weight, block.distance + voxel, block.weight + voxel);
    if (s.near != 0) colour_voxels(view, s, settings.taken_out, voxel, block);
  }
  return changed;
}

}  // namespace lcmslam
