#include <lcmslam/simulation/ray_caster.hpp>

#include <embree3/rtcore.h>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <stdexcept>

namespace lcmslam {
namespace {

using Eigen::Vector3d;

/// Squared distance from a point to the segment a..b.
double squared_distance(const Vector3d& p, const Vector3d& a, const Vector3d& b) {
  const Vector3d edge = b - a;
  const double length2 = edge.squaredNorm();
  const double t = length2 > 0 ? std::clamp((p - a).dot(edge) / length2, 0.0, 1.0) : 0.0;
  return (a + t * edge - p).squaredNorm();
}

/// To the plane where the foot lies inside the triangle, else to the nearest edge.
double squared_distance(const Vector3d& p, const SceneTriangle& triangle) {
  const Vector3d corner[3] = {triangle.corner[0].cast<double>(), triangle.corner[1].cast<double>(),
                              triangle.corner[2].cast<double>()};
  const Vector3d normal = (corner[1] - corner[0]).cross(corner[2] - corner[0]);
  bool inside = normal.squaredNorm() > 0;
  double nearest = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 3; ++k) {
    const Vector3d &a = corner[k], &b = corner[(k + 1) % 3];
    inside = inside && (b - a).cross(p - a).dot(normal) >= 0;
    nearest = std::min(nearest, squared_distance(p, a, b));
  }
  if (!inside) return nearest;
  const double height = (p - corner[0]).dot(normal) / normal.norm();
  return height * height;
}

struct DistanceQuery {
  const std::vector<SceneTriangle>* triangles;
  Vector3d point;
  double squared = std::numeric_limits<double>::infinity();
};

bool visit_triangle(RTCPointQueryFunctionArguments* arguments) {
  auto& query = *static_cast<DistanceQuery*>(arguments->userPtr);
  const double squared = squared_distance(query.point, (*query.triangles)[arguments->primID]);
  if (squared >= query.squared) return false;
  query.squared = squared;
  arguments->query->radius = static_cast<float>(std::sqrt(squared)) * 1.0001f;  // search nearer ones only
  return true;
}

}  // namespace

struct RayCaster::Handles {
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;
  std::vector<SceneTriangle> triangles;
  ~Handles() {
    if (scene) rtcReleaseScene(scene);
    if (device) rtcReleaseDevice(device);
  }
};

void RayPacket::aim(const cv::Vec2f* row, int first, int width, const Eigen::Matrix3f& R_world_camera) {
  for (int i = 0; i < size; ++i) {
    const cv::Vec2f& ideal = row[std::min(first + i, width - 1)];
    const Eigen::Vector3f direction = R_world_camera * Eigen::Vector3f(ideal[0], ideal[1], 1);
    x[i] = direction.x(), y[i] = direction.y(), z[i] = direction.z();
  }
}

RayCaster::RayCaster(const Scene& scene) : handles_(std::make_unique<Handles>()) {
  handles_->triangles = scene.triangles;
  const std::size_t count = scene.triangles.size();
  handles_->device = rtcNewDevice("threads=1");  // building is quick; the cores belong to others
  if (!handles_->device) throw std::runtime_error("Embree cannot make a device on this processor");
  handles_->scene = rtcNewScene(handles_->device);
  rtcSetSceneFlags(handles_->scene, RTC_SCENE_FLAG_ROBUST);  // no gaps between neighbouring triangles
  RTCGeometry geometry = rtcNewGeometry(handles_->device, RTC_GEOMETRY_TYPE_TRIANGLE);
  auto* vertices = static_cast<float*>(rtcSetNewGeometryBuffer(
      geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), 3 * count));
  auto* indices = static_cast<unsigned*>(rtcSetNewGeometryBuffer(
      geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(unsigned), count));
  for (std::size_t i = 0; i < 3 * count; ++i) {
    const Eigen::Vector3f& corner = scene.triangles[i / 3].corner[i % 3];
    std::copy_n(corner.data(), 3, vertices + 3 * i);
    indices[i] = static_cast<unsigned>(i);
  }
  rtcCommitGeometry(geometry);
  rtcAttachGeometryByID(handles_->scene, geometry, 0);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(handles_->scene);
}

RayCaster::~RayCaster() = default;

void RayCaster::cast(const Eigen::Vector3f& origin, RayPacket& rays) const {
  RTCRayHit8 packet;
  for (int i = 0; i < RayPacket::size; ++i) {
    packet.ray.org_x[i] = origin.x();
    packet.ray.org_y[i] = origin.y();
    packet.ray.org_z[i] = origin.z();
    packet.ray.tnear[i] = 0;
    packet.ray.tfar[i] = std::numeric_limits<float>::infinity();
    packet.ray.time[i] = 0;
    packet.ray.mask[i] = ~0u;
    packet.ray.flags[i] = 0;
    packet.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
    packet.hit.primID[i] = RTC_INVALID_GEOMETRY_ID;
  }
  std::memcpy(packet.ray.dir_x, rays.x, sizeof rays.x);
  std::memcpy(packet.ray.dir_y, rays.y, sizeof rays.y);
  std::memcpy(packet.ray.dir_z, rays.z, sizeof rays.z);
  alignas(32) static constexpr int valid[8] = {-1, -1, -1, -1, -1, -1, -1, -1};
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  rtcIntersect8(valid, handles_->scene, &context, &packet);
  std::memcpy(rays.range, packet.ray.tfar, sizeof rays.range);
  std::memcpy(rays.u, packet.hit.u, sizeof rays.u);
  std::memcpy(rays.v, packet.hit.v, sizeof rays.v);
  for (int i = 0; i < RayPacket::size; ++i)
    rays.triangle[i] =
        packet.hit.geomID[i] == RTC_INVALID_GEOMETRY_ID ? RayPacket::none : packet.hit.primID[i];
}

float RayCaster::cast(const Eigen::Vector3f& origin, const Eigen::Vector3f& direction) const {
  RayPacket rays;
  for (int i = 0; i < RayPacket::size; ++i) {
    rays.x[i] = direction.x();
    rays.y[i] = direction.y();
    rays.z[i] = direction.z();
  }
  cast(origin, rays);
  return rays.range[0];
}

double RayCaster::distance(const Eigen::Vector3d& point) const {
  RTCPointQuery position;
  position.x = static_cast<float>(point.x());
  position.y = static_cast<float>(point.y());
  position.z = static_cast<float>(point.z());
  position.radius = std::numeric_limits<float>::infinity();
  position.time = 0;
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  DistanceQuery query{&handles_->triangles, point};
  rtcPointQuery(handles_->scene, &position, &context, visit_triangle, &query);
  return std::sqrt(query.squared);
}

}  // namespace lcmslam
