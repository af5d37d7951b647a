// Binary glTF 2.0 (Khronos specification, sections 3.6, 3.7 and 4.4): a JSON chunk that describes a chunk of
// bytes.

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>

#include <lcmslam/files/atomic_file.hpp>
#include <lcmslam/files/decimal_text.hpp>
#include <lcmslam/surface/mesh_export.hpp>

namespace lcmslam {
namespace {

void add_word(std::string& bytes, std::uint32_t word) {
  bytes.append(reinterpret_cast<const char*>(&word), sizeof word);
}

void add_vectors(std::string& bytes, const std::vector<Eigen::Vector3f>& vectors) {
  for (const Eigen::Vector3f& v : vectors)
    bytes.append(reinterpret_cast<const char*>(v.data()), 3 * sizeof(float));
}

/// 16 bits: eight would lose what is dark, because glTF's colours are linear and images are not.
std::array<std::uint16_t, 256> make_linear() {
  std::array<std::uint16_t, 256> table{};
  for (std::size_t i = 0; i < table.size(); ++i) {
    const double c = static_cast<double>(i) / 255;
    const double linear = c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
    table[i] = static_cast<std::uint16_t>(std::lround(65535 * linear));
  }
  return table;
}

void add_colours(std::string& bytes, const std::vector<cv::Vec3b>& colours) {
  const std::array<std::uint16_t, 256> linear = make_linear();
  for (const cv::Vec3b& c : colours) {
    const std::uint16_t rgba[] = {linear[c[2]], linear[c[1]], linear[c[0]], 65535};
    bytes.append(reinterpret_cast<const char*>(rgba), sizeof rgba);
  }
}

std::string array_text(const Eigen::Vector3f& v) {
  std::string text;
  for (const float coordinate : {v.x(), v.y(), v.z()}) {
    text += text.empty() ? '[' : ',';
    append_general(text, static_cast<double>(coordinate), 9);
  }
  return text + ']';
}

std::string view_text(std::size_t offset, std::size_t length, int target) {
  return R"({"buffer":0,"byteOffset":)" + std::to_string(offset) + R"(,"byteLength":)" +
         std::to_string(length) + R"(,"target":)" + std::to_string(target) + "}";
}

std::string accessor_text(int view, int component, std::size_t count, const std::string& rest) {
  return R"({"bufferView":)" + std::to_string(view) + R"(,"componentType":)" + std::to_string(component) +
         R"(,"count":)" + std::to_string(count) + "," + rest + "}";
}

constexpr const char* head = R"({"asset":{"version":"2.0","generator":"lcmslam"},"scene":0,)";

/// glTF has no empty arrays: without triangles there is a scene with nothing in it.
std::string empty_description() {
  return std::string(head) + R"("scenes":[{"name":"lcmslam surface"}]})";
}

std::string description(const Mesh& mesh) {
  constexpr int floats = 5126, shorts = 5123, words = 5125, array_buffer = 34962, index_buffer = 34963;
  Eigen::Vector3f low = mesh.vertices.front(), high = low;
  for (const Eigen::Vector3f& v : mesh.vertices) {
    low = low.cwiseMin(v);
    high = high.cwiseMax(v);
  }
  const std::size_t n = mesh.vertices.size(), corners = 3 * mesh.triangles.size();
  std::string json = head;
  // A quarter turn about x takes z, up in our maps, to glTF's y.
  json += R"("scenes":[{"name":"lcmslam surface","nodes":[0]}],)";
  json += R"("nodes":[{"mesh":0,"rotation":[-0.70710678,0,0,0.70710678]}],)";
  json += R"("materials":[{"pbrMetallicRoughness":{"metallicFactor":0,"roughnessFactor":1}}],)";
  json +=
      R"("meshes":[{"primitives":[{"attributes":{"POSITION":0,"NORMAL":1,"COLOR_0":2},"indices":3,"material":0}]}],)";
  json += R"("accessors":[)" +
          accessor_text(0, floats, n,
                        R"("type":"VEC3","min":)" + array_text(low) + R"(,"max":)" + array_text(high)) +
          "," + accessor_text(1, floats, n, R"("type":"VEC3")") + "," +
          accessor_text(2, shorts, n, R"("type":"VEC4","normalized":true)") + "," +
          accessor_text(3, words, corners, R"("type":"SCALAR")") + "],";
  json += R"("bufferViews":[)" + view_text(0, 12 * n, array_buffer) + "," +
          view_text(12 * n, 12 * n, array_buffer) + "," + view_text(24 * n, 8 * n, array_buffer) + "," +
          view_text(32 * n, 4 * corners, index_buffer) + "],";
  return json + R"("buffers":[{"byteLength":)" + std::to_string(32 * n + 4 * corners) + "}]}";
}

}  // namespace

std::string mesh_glb(const Mesh& mesh) {
  check_mesh(mesh);
  const bool empty = mesh.triangles.empty();
  std::string json = empty ? empty_description() : description(mesh);
  json.resize((json.size() + 3) / 4 * 4, ' ');
  const std::size_t data = empty ? 0 : 32 * mesh.vertices.size() + 12 * mesh.triangles.size();
  const std::size_t whole = 20 + json.size() + (empty ? 0 : 8 + data);
  if (whole > std::numeric_limits<std::uint32_t>::max())
    throw std::runtime_error("a .glb has at most 4 GB, this mesh needs " + std::to_string(whole) +
                             " bytes; .ply has no such limit");
  std::string bytes;
  bytes.reserve(whole);
  bytes += "glTF";
  add_word(bytes, 2);  // version
  add_word(bytes, static_cast<std::uint32_t>(whole));
  add_word(bytes, static_cast<std::uint32_t>(json.size()));
  bytes += "JSON" + json;
  if (!empty) {
    add_word(bytes, static_cast<std::uint32_t>(data));
    bytes += std::string("BIN\0", 4);
    add_vectors(bytes, mesh.vertices);
    add_vectors(bytes, mesh.normals);
    add_colours(bytes, mesh.colours);
    for (const auto& triangle : mesh.triangles)
      for (const std::uint32_t vertex : triangle) add_word(bytes, vertex);
  }
  return bytes;
}

void save_mesh_glb(const FilePlace& file, const Mesh& mesh) {
  std::string bytes;
  try {
    bytes = mesh_glb(mesh);
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(file.path().string() + ": " + error.what());
  }
  write_atomically(file, bytes);
}

}  // namespace lcmslam
