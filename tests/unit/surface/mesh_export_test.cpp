// What we write, a foreign reader must read: assimp.

#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <assimp/Importer.hpp>
#include <cstring>
#include <fstream>
#include <iterator>

#include <lcmslam/surface/mesh_export.hpp>

namespace lcmslam {
namespace {

/// A tetrahedron without symmetry.
Mesh sample() {
  Mesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 2, 0}, {0, 0, 3}};
  mesh.normals = {{-1, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  mesh.colours = {{0, 0, 255}, {0, 255, 0}, {255, 0, 0}, {188, 188, 188}};
  mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  return mesh;
}

std::filesystem::path file_named(const std::string& name) {
  return std::filesystem::path(::testing::TempDir()) / name;
}

/// Corners of all triangles with their colours, as the reader sees them in the scene's frame.
struct Corner {
  Eigen::Vector3f place, normal;
  Eigen::Vector3f colour;  // RGB, 0 to 1
};
std::vector<Corner> read_corners(const std::filesystem::path& file) {
  Assimp::Importer importer;
  const aiScene* scene = importer.ReadFile(file.string(), aiProcess_PreTransformVertices);
  if (scene == nullptr || scene->mNumMeshes != 1) {
    ADD_FAILURE() << file << ": " << importer.GetErrorString();
    return {};
  }
  const aiMesh& mesh = *scene->mMeshes[0];
  std::vector<Corner> corners;
  for (unsigned f = 0; f < mesh.mNumFaces; ++f)
    for (unsigned k = 0; k < mesh.mFaces[f].mNumIndices; ++k) {
      const unsigned i = mesh.mFaces[f].mIndices[k];
      const aiVector3D &p = mesh.mVertices[i], &n = mesh.mNormals[i];
      Corner corner{{p.x, p.y, p.z}, {n.x, n.y, n.z}, {-1, -1, -1}};
      if (mesh.HasVertexColors(0))
        corner.colour = {mesh.mColors[0][i].r, mesh.mColors[0][i].g, mesh.mColors[0][i].b};
      corners.push_back(corner);
    }
  return corners;
}

void expect_sample(const std::vector<Corner>& corners, bool y_up) {
  const Mesh mesh = sample();
  ASSERT_EQ(corners.size(), 12u);
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const std::size_t vertex = mesh.triangles[i / 3][i % 3];
    const auto turned = [&](const Eigen::Vector3f& v) {
      return y_up ? Eigen::Vector3f(v.x(), v.z(), -v.y()) : v;
    };
    EXPECT_LT((corners[i].place - turned(mesh.vertices[vertex])).norm(), 1e-4f) << i;
    EXPECT_LT((corners[i].normal - turned(mesh.normals[vertex])).norm(), 1e-3f) << i;
    const cv::Vec3b& bgr = mesh.colours[vertex];
    for (int c = 0; c < 3; ++c) {
      const float srgb = static_cast<float>(bgr[2 - c]) / 255;
      // 188 is half of the light.
      const float expected = y_up && srgb > 0.1f && srgb < 0.9f ? 0.503f : srgb;
      EXPECT_NEAR(corners[i].colour[c], expected, 2e-3f) << i;
    }
  }
}

TEST(MeshExport, OthersReadPly) {
  save_mesh(file_named("sample.ply"), sample());
  expect_sample(read_corners(file_named("sample.ply")), false);
}

TEST(MeshExport, OthersReadObj) {
  save_mesh(file_named("sample.obj"), sample());
  expect_sample(read_corners(file_named("sample.obj")), false);
}

TEST(MeshExport, OthersReadGltfWithItsUpAndItsColours) {
  save_mesh(file_named("sample.glb"), sample());
  expect_sample(read_corners(file_named("sample.glb")), true);
}

TEST(MeshExport, ChunksOfGltfAreAsLongAsTheySay) {
  for (const Mesh& mesh : {sample(), Mesh()}) {
    save_mesh(file_named("chunks.glb"), mesh);
    std::ifstream in(file_named("chunks.glb"), std::ios::binary);
    const std::string bytes((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
    const auto word = [&](std::size_t at) {
      std::uint32_t value;
      std::memcpy(&value, bytes.data() + at, sizeof value);
      return value;
    };
    ASSERT_GE(bytes.size(), 20u);
    EXPECT_EQ(word(8), bytes.size());
    std::size_t at = 12;
    while (at + 8 <= bytes.size()) {
      EXPECT_EQ(word(at) % 4, 0u);
      at += 8 + word(at);
    }
    EXPECT_EQ(at, bytes.size());
  }
}

TEST(MeshExport, AMeshThatDoesNotFitIsRefused) {
  using ::testing::HasSubstr;
  const auto message_of = [](const std::string& name, const Mesh& mesh) -> std::string {
    try {
      save_mesh(file_named(name), mesh);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "";
  };
  Mesh mesh = sample();
  mesh.triangles[1][2] = 4;
  for (const char* name : {"wrong.ply", "wrong.obj", "wrong.glb"}) {
    EXPECT_THAT(message_of(name, mesh), HasSubstr("vertex 4 of 4"));
    EXPECT_FALSE(std::filesystem::exists(file_named(name)));
  }
  mesh = sample();
  mesh.normals.pop_back();
  EXPECT_THAT(message_of("wrong.glb", mesh), HasSubstr("3 normals"));
  EXPECT_THAT(message_of("sample.stl", sample()), HasSubstr(".ply, .obj or .glb"));
}

}  // namespace
}  // namespace lcmslam
