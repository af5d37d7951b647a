#include <lcmslam/surface/block_update.hpp>

#include <algorithm>
#include <cstring>

#include <lcmslam/parallel/instruction_set.hpp>

namespace lcmslam {
namespace {

constexpr int side = VoxelBlock::side;
constexpr int slab = side * side;  // voxels of one z, worked on together
constexpr int colour_share = 4;    // of a look's weight, for its colour: bytes hold ten such looks
static_assert(VoxelBlock::full_look < SurfacePixel::coloured);
static_assert(sizeof(SurfacePixel) == 20);

struct Slab {
  float first[3];                                  // m, of the first voxel
  float from_x[slab], from_y[slab], from_z[slab];  // m, of each from the first
  float x[slab], y[slab], z[slab];                 // m, of the voxels
  std::int32_t pixel[slab];
  int seen;                                          // whether any pixel sees a voxel
  float nx[slab], ny[slab], nz[slab], offset[slab];  // the pixels' planes
  std::uint32_t look[slab];                          // likewise: colour and weight
  float distance[slab], weight[slab];                // as they are kept
  std::int32_t colour_look[slab];                    // likewise
  int weighed, near;                                 // whether any voxel has a weight, and one a colour's
};

// Voxel centres and the pixels that see them.
template <LensKind kind>
__attribute__((always_inline)) inline void find_pixels_of(const Lens& lens, Slab& s) {
  const float first_x = s.first[0], first_y = s.first[1], first_z = s.first[2];
  const Lens l = lens;  // by value: no store into the slab changes it
  int seen = 0;
  for (int i = 0; i < slab; ++i) {
    const float x = first_x + s.from_x[i], y = first_y + s.from_y[i], z = first_z + s.from_z[i];
    s.x[i] = x;
    s.y[i] = y;
    s.z[i] = z;
    const int pixel = l.pixel<kind>(x, y, z);
    s.pixel[i] = pixel;
    seen |= pixel ^ l.nothing;
  }
  s.seen = seen;
}

LCMSLAM_VECTORISED(find_pinhole_pixels, (const Lens& lens, Slab& s), (lens, s)) {
  find_pixels_of<LensKind::pinhole>(lens, s);
}
LCMSLAM_VECTORISED(find_polynomial_pixels, (const Lens& lens, Slab& s), (lens, s)) {
  find_pixels_of<LensKind::polynomial>(lens, s);
}
LCMSLAM_VECTORISED(find_rational_pixels, (const Lens& lens, Slab& s), (lens, s)) {
  find_pixels_of<LensKind::rational>(lens, s);
}

void find_pixels(const Lens& lens, Slab& s) {
  switch (lens.kind) {
    case LensKind::pinhole:
      return find_pinhole_pixels(lens, s);
    case LensKind::polynomial:
      return find_polynomial_pixels(lens, s);
    case LensKind::rational:
      return find_rational_pixels(lens, s);
  }
}

using Four = float __attribute__((vector_size(16)));

/// Four planes at a time, transposed: faster than the processor's own gathering of one number from eight
/// places.
void fetch(const SurfaceView& view, Slab& s) {
  for (int i = 0; i < slab; i += 4) {
    Four plane[4];
    for (int k = 0; k < 4; ++k) {
      const SurfacePixel& pixel = view.pixels[static_cast<std::size_t>(s.pixel[i + k])];
      std::memcpy(plane + k, pixel.plane.data(), sizeof(Four));
      std::memcpy(s.look + i + k, pixel.colour.data(), sizeof(std::uint32_t));
    }
    const Four xy_of_01 = __builtin_shufflevector(plane[0], plane[1], 0, 4, 1, 5),
               xy_of_23 = __builtin_shufflevector(plane[2], plane[3], 0, 4, 1, 5),
               zo_of_01 = __builtin_shufflevector(plane[0], plane[1], 2, 6, 3, 7),
               zo_of_23 = __builtin_shufflevector(plane[2], plane[3], 2, 6, 3, 7);
    const Four columns[] = {__builtin_shufflevector(xy_of_01, xy_of_23, 0, 1, 4, 5),
                            __builtin_shufflevector(xy_of_01, xy_of_23, 2, 3, 6, 7),
                            __builtin_shufflevector(zo_of_01, zo_of_23, 0, 1, 4, 5),
                            __builtin_shufflevector(zo_of_01, zo_of_23, 2, 3, 6, 7)};
    float* const out[] = {s.nx + i, s.ny + i, s.nz + i, s.offset + i};
    for (int k = 0; k < 4; ++k) std::memcpy(out[k], columns + k, sizeof(Four));
  }
}

// What the pixels say of the voxels.
LCMSLAM_VECTORISED(measure, (float truncation, float colour_reach, Slab& s), (truncation, colour_reach, s)) {
  const float to_kept = VoxelBlock::full_distance / truncation, to_fade = 2 / truncation;
  int weighed = 0, near = 0;
  for (int i = 0; i < slab; ++i) {
    const float d = s.nx[i] * s.x[i] + s.ny[i] * s.y[i] + s.nz[i] * s.z[i] + s.offset[i];
    // The farther behind the surface, the less is known: the back of something thin has its own looks.
    const float behind = 2 + d * to_fade;
    const float shade = behind > 0 ? behind : 0.0f;
    const float fade = shade < 1 ? shade : 1.0f;
    const auto look = static_cast<std::int32_t>(s.look[i] >> 24);
    const int full = look & (SurfacePixel::coloured - 1);
    const int w = static_cast<int>(static_cast<float>(full) * fade + 0.5f);
    s.distance[i] = (d < truncation ? d : truncation) * to_kept;
    s.weight[i] = static_cast<float>(w);
    const bool is_near = (d < colour_reach) & (d > -colour_reach) & (look > SurfacePixel::coloured);
    const int of_colour = is_near ? (full + colour_share - 1) / colour_share : 0;
    s.colour_look[i] = of_colour;
    weighed |= w;
    near |= of_colour;
  }
  s.weighed = weighed;
  s.near = near;
}

/// The nearest whole number of 16 bits: the last bits of the sum.
__attribute__((always_inline)) inline std::int16_t rounded(float number) {
  const float sum = number + 12582912.0f;  // 1.5 * 2^23: here floats are one apart
  std::int32_t bits;
  std::memcpy(&bits, &sum, sizeof bits);
  return static_cast<std::int16_t>(bits);
}

LCMSLAM_VECTORISED(put_in,
                   (const Slab& s, float most_weight, std::int16_t* __restrict distance,
                    std::uint16_t* __restrict weight),
                   (s, most_weight, distance, weight)) {
  for (int i = 0; i < slab; ++i) {
    const auto old = static_cast<float>(distance[i]), old_weight = static_cast<float>(weight[i]);
    const float sum = old_weight + s.weight[i];
    const float share = s.weight[i] / (sum > 1 ? sum : 1.0f);
    const float most = old_weight > most_weight ? old_weight : most_weight;
    distance[i] = rounded(old + (s.distance[i] - old) * share);
    weight[i] = static_cast<std::uint16_t>(static_cast<int>(sum < most ? sum : most));
  }
}

LCMSLAM_VECTORISED(take_out,
                   (const Slab& s, std::int16_t* __restrict distance, std::uint16_t* __restrict weight),
                   (s, distance, weight)) {
  for (int i = 0; i < slab; ++i) {
    const auto old = static_cast<float>(distance[i]), old_weight = static_cast<float>(weight[i]);
    const float left = old_weight - s.weight[i];
    const float mean = old - (s.distance[i] - old) * s.weight[i] / (left > 1 ? left : 1.0f);
    const float low = mean < VoxelBlock::full_distance ? mean : VoxelBlock::full_distance;
    const float bounded = low > -VoxelBlock::full_distance ? low : -VoxelBlock::full_distance;
    distance[i] = rounded(left >= 1 ? bounded : 0.0f);
    weight[i] = static_cast<std::uint16_t>(static_cast<int>(left > 0 ? left : 0.0f));
  }
}

/// `share` in 32768th.
__attribute__((always_inline)) inline std::uint8_t mixed(std::uint8_t old, std::uint32_t seen,
                                                         std::int16_t share) {
  const auto way = static_cast<std::int16_t>(static_cast<std::int16_t>(seen & 255) - old);
  const auto step = static_cast<std::int16_t>(((way * share >> 14) + 1) >> 1);
  return static_cast<std::uint8_t>(old + step);
}

// Of the voxels near the surface.
LCMSLAM_VECTORISED(put_in_colours,
                   (const Slab& s, std::uint8_t* __restrict blue, std::uint8_t* __restrict green,
                    std::uint8_t* __restrict red, std::uint8_t* __restrict weight),
                   (s, blue, green, red, weight)) {
  std::int16_t share[slab];
  for (int i = 0; i < slab; ++i) {
    const int look = s.colour_look[i], sum = weight[i] + look;
    const float part = static_cast<float>(look) / static_cast<float>(sum > 1 ? sum : 1);
    share[i] = static_cast<std::int16_t>(static_cast<int>(32767 * part));
    weight[i] = static_cast<std::uint8_t>(
        sum < VoxelBlock::most_colour_weight ? sum : VoxelBlock::most_colour_weight);
  }
  for (int i = 0; i < slab; ++i) {
    const std::uint32_t seen = s.look[i];
    blue[i] = mixed(blue[i], seen, share[i]);
    green[i] = mixed(green[i], seen >> 8, share[i]);
    red[i] = mixed(red[i], seen >> 16, share[i]);
  }
}

/// The weight alone: the looks that stay bring the mean back.
void take_out_colours(const Slab& s, std::uint8_t* weight) {
  for (int i = 0; i < slab; ++i)
    weight[i] = static_cast<std::uint8_t>(std::max(weight[i] - s.colour_look[i], 0));
}

void place_voxels(const BlockPlace& place, Slab& s) {
  float* const from[] = {s.from_x, s.from_y, s.from_z};
  for (int axis = 0; axis < 3; ++axis)
    for (int i = 0; i < slab; ++i) {
      const int column = i % side, row = i / side;
      from[axis][i] =
          static_cast<float>(column) * place.step[0][axis] + static_cast<float>(row) * place.step[1][axis];
    }
}

}  // namespace

bool update_block(const SurfaceView& view, const BlockPlace& place, const LookSettings& settings,
                  VoxelBlock& block) {
  bool changed = false;
  Slab s;
  place_voxels(place, s);
  for (int z = 0; z < side; ++z) {
    for (int axis = 0; axis < 3; ++axis)
      s.first[axis] = place.first[axis] + static_cast<float>(z) * place.step[2][axis];
    find_pixels(view.lens, s);
    if (s.seen == 0) continue;
    fetch(view, s);
    measure(settings.truncation, settings.colour_reach, s);
    if (s.weighed == 0) continue;
    changed = true;
    const int voxel = slab * z;
    std::uint8_t* const colour_weight = block.colour_weight + voxel;
    if (settings.taken_out) {
      take_out(s, block.distance + voxel, block.weight + voxel);
      take_out_colours(s, colour_weight);
      continue;
    }
    put_in(s, settings.most_weight, block.distance + voxel, block.weight + voxel);
    if (s.near != 0)
      put_in_colours(s, block.blue + voxel, block.green + voxel, block.red + voxel, colour_weight);
  }
  return changed;
}

}  // namespace lcmslam
