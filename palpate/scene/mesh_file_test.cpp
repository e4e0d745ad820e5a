#include "palpate/scene/mesh_file.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstring>
#include <set>

#include "palpate/core/file.h"
#include "palpate/math/random_vector.h"

namespace palpate::scene {
namespace {

// Writers of each format, which share nothing with the readers.
template <typename T>
void put(std::string& out, T value) {
  char bytes[sizeof(T)];
  std::memcpy(bytes, &value, sizeof(T));  // tests run on little-endian machines
  out.append(bytes, sizeof(T));
}
std::string binary_stl(const TriangleMesh& mesh) {
  std::string out(80, ' ');
  out.replace(0, 5, "solid");  // as some programs write, to mislead
  put(out, static_cast<std::uint32_t>(mesh.triangles.size()));
  for (const auto& t : mesh.triangles) {
    for (int i = 0; i < 3; ++i) put(out, 0.0f);
    for (const auto corner : t)
      for (int i = 0; i < 3; ++i) put(out, static_cast<float>(mesh.vertices[corner][i]));
    put(out, std::uint16_t{7});
  }
  return out;
}
std::string text_stl(const TriangleMesh& mesh) {
  std::string out = "solid thing of two words\n";
  for (const auto& t : mesh.triangles) {
    out += "  facet normal 0 0 0\n    outer loop\n";
    for (const auto c : t)
      out += fmt::format("      vertex {} {} {}\r\n", mesh.vertices[c].x(), mesh.vertices[c].y(),
                         mesh.vertices[c].z());
    out += "    endloop\n  endfacet\n";
  }
  return out + "endsolid thing";
}
std::string obj(const TriangleMesh& mesh) {
  std::string out = "# made by a test\no thing\n";
  for (const auto& v : mesh.vertices) out += fmt::format("v {} {} {} 1.0\nvn 0 0 1\n", v.x(), v.y(), v.z());
  const auto n = static_cast<int>(mesh.vertices.size());
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto& t = mesh.triangles[i];
    if (i % 2)
      out += fmt::format("f {}/1/1 {}//2 {}\n", t[0] + 1, t[1] + 1, t[2] + 1);
    else
      out += fmt::format("f {} {} {}\n", static_cast<int>(t[0]) - n, static_cast<int>(t[1]) - n,
                         static_cast<int>(t[2]) - n);
  }
  return out;
}
std::string ply(const TriangleMesh& mesh, bool text) {
  std::string out = fmt::format(
      "ply\nformat {} 1.0\ncomment made by a test\nelement vertex {}\nproperty float x\nproperty uchar red\n"
      "property double y\nproperty float z\nproperty list uchar short extra\nelement face {}\n"
      "property list uchar int vertex_indices\nproperty short flag\nend_header\n",
      text ? "ascii" : "binary_little_endian", mesh.vertices.size(), mesh.triangles.size());
  for (const auto& v : mesh.vertices) {
    if (text) {
      out += fmt::format("{} 255 {} {} 2 -1 -2\n", v.x(), v.y(), v.z());
      continue;
    }
    put(out, static_cast<float>(v.x()));
    put(out, std::uint8_t{255});
    put(out, v.y());
    put(out, static_cast<float>(v.z()));
    put(out, std::uint8_t{1});
    put(out, std::int16_t{-300});
  }
  for (const auto& t : mesh.triangles) {
    if (text) {
      out += fmt::format("3 {} {} {} -5\n", t[0], t[1], t[2]);
      continue;
    }
    put(out, std::uint8_t{3});
    for (const auto c : t) put(out, static_cast<std::int32_t>(c));
    put(out, std::int16_t{-5});
  }
  return out;
}

std::vector<std::pair<const char*, std::string>> every_format(const TriangleMesh& mesh) {
  return {{"binary.stl", binary_stl(mesh)},
          {"text.stl", text_stl(mesh)},
          {"mesh.obj", obj(mesh)},
          {"text.ply", ply(mesh, true)},
          {"binary.ply", ply(mesh, false)}};
}

// A closed bumpy ball whose coordinates are floats, so that every format keeps them exactly.
TriangleMesh bumpy_ball(Random& random) {
  auto mesh = sphere_mesh(50.0, 6, 9);
  for (auto& v : mesh.vertices) {
    const double longer = random.uniform(0.8, 1.2);
    for (Eigen::Index i = 0; i < 3; ++i) v[i] = std::round(64.0 * longer * v[i]) / 64.0;
  }
  return mesh;
}

// Triangles by the places of their corners, the least first: how they face shows, how they are numbered not.
std::multiset<std::vector<double>> by_places(const TriangleMesh& mesh, double scale) {
  std::multiset<std::vector<double>> all;
  for (auto t : mesh.triangles) {
    const auto place = [&](std::uint32_t c) {
      const Vector3 v = scale * mesh.vertices[c];
      return std::vector<double>{v.x(), v.y(), v.z()};
    };
    std::size_t least = 0;
    for (std::size_t i = 1; i < 3; ++i)
      if (place(t[i]) < place(t[least])) least = i;
    std::vector<double> places;
    for (std::size_t i = 0; i < 3; ++i)
      for (const double x : place(t[(least + i) % 3])) places.push_back(x);
    all.insert(places);
  }
  return all;
}

double volume_of(const TriangleMesh& mesh) {
  double six = 0.0;
  for (const auto& t : mesh.triangles)
    six += mesh.vertices[t[0]].dot(mesh.vertices[t[1]].cross(mesh.vertices[t[2]]));
  return six / 6.0;
}

TEST(MeshFile, EveryFormatGivesTheSameMesh) {
  Random random(1, "mesh/formats");
  for (int k = 0; k < 10; ++k) {
    const auto mesh = bumpy_ball(random);
    for (const auto& [name, content] : every_format(mesh)) {
      const auto file = parse_mesh(content, name, 0.001);
      ASSERT_TRUE(file) << name << ": " << file.error().message;
      EXPECT_EQ(by_places(file->mesh, 1.0), by_places(mesh, 0.001)) << name;
      EXPECT_EQ(file->mesh.vertices.size(), mesh.vertices.size()) << name << ": equal vertices are one";
      EXPECT_TRUE(file->repaired.closed()) << name;
      EXPECT_EQ(file->repaired.parts, 1u);
      EXPECT_EQ(file->repaired.turned_triangles, 0u);
    }
  }
}

TEST(MeshFile, TheUnitIsTheCallers) {
  Random random(2, "mesh/unit");
  const auto content = obj(bumpy_ball(random));
  const double metres = volume_of(parse_mesh(content, "a.obj", 1.0)->mesh);
  EXPECT_NEAR(volume_of(parse_mesh(content, "a.obj", 0.001)->mesh) / metres, 1e-9, 1e-21);
  EXPECT_FALSE(parse_mesh(content, "a.obj", 0.0));
  EXPECT_FALSE(parse_mesh(content, "a.obj", std::nan("")));
}

TEST(MeshFile, TrianglesThatFaceAnyWayFaceOutwardsAfterwards) {
  Random random(3, "mesh/turned");
  for (int k = 0; k < 20; ++k) {
    const auto mesh = bumpy_ball(random);
    auto damaged = mesh;
    append(damaged, box_mesh({100, 100, 100}, {101, 102, 103}));
    const auto good = by_places(damaged, 1.0);
    for (auto& t : damaged.triangles) {
      if (random.chance(0.5)) std::swap(t[0], t[1]);
      std::swap(t, damaged.triangles[random.below(damaged.triangles.size())]);
    }
    const auto file = parse_mesh(binary_stl(damaged), "a.stl", 1.0);
    ASSERT_TRUE(file);
    EXPECT_EQ(by_places(file->mesh, 1.0), good);
    EXPECT_GT(volume_of(file->mesh), 0.0);
    EXPECT_EQ(file->repaired.parts, 2u);
    EXPECT_TRUE(file->repaired.closed());
    EXPECT_GT(file->repaired.turned_triangles, 20u);
  }
}

TEST(MeshFile, AnOpenPartKeepsTheWayMostOfItFaces) {
  auto mesh = rectangle_mesh({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  mesh.vertices.push_back({2, 0, 0});
  mesh.triangles.push_back({1, 4, 2});
  std::swap(mesh.triangles[0][0], mesh.triangles[0][1]);
  const auto report = repair(mesh);
  EXPECT_EQ(report.turned_triangles, 1u);
  EXPECT_EQ(report.open_edges, 5u);
  for (const auto& t : mesh.triangles) {
    const Vector3 n =
        (mesh.vertices[t[1]] - mesh.vertices[t[0]]).cross(mesh.vertices[t[2]] - mesh.vertices[t[0]]);
    EXPECT_GT(n.z(), 0.0);
  }
}

TEST(MeshFile, WhatHasNoAreaOrIsThereTwiceIsDroppedAndCounted) {
  auto mesh = box_mesh({0, 0, 0}, {1e-3, 2e-3, 3e-3});
  const auto good = by_places(mesh, 1.0);
  mesh.vertices.push_back(mesh.vertices[3]);                             // a copy: welded
  mesh.vertices.push_back(0.5 * (mesh.vertices[0] + mesh.vertices[1]));  // between two others
  mesh.triangles.push_back({3, 8, 5});                                   // two corners in one place
  mesh.triangles.push_back({0, 9, 1});                                   // three on a line
  mesh.triangles.push_back({mesh.triangles[0][1], mesh.triangles[0][0], mesh.triangles[0][2]});
  const auto report = repair(mesh);
  EXPECT_EQ(report.welded_vertices, 1u);
  EXPECT_EQ(report.dropped_triangles, 2u);
  EXPECT_EQ(report.repeated_triangles, 1u);
  EXPECT_TRUE(report.closed());
  EXPECT_EQ(mesh.vertices.size(), 8u) << "vertices of no triangle go too";
  EXPECT_EQ(by_places(mesh, 1.0), good);
  EXPECT_EQ(
      report.text(),
      "1 part, closed, 1 equal vertices merged, 2 triangles without area dropped, 1 triangle there twice "
      "dropped");
}

TEST(MeshFile, AMoebiusStripIsToldOf) {
  TriangleMesh strip;
  constexpr std::uint32_t n = 8;
  for (std::uint32_t i = 0; i < n; ++i) {
    const double a = 6.283185307179586 * i / n;
    const Vector3 middle(std::cos(a), std::sin(a), 0),
        across(0.2 * std::cos(a / 2) * middle + Vector3(0, 0, 0.2 * std::sin(a / 2)));
    strip.vertices.push_back(middle - across);
    strip.vertices.push_back(middle + across);
  }
  for (std::uint32_t i = 0; i < n; ++i) {
    const std::uint32_t a = 2 * i, b = a + 1, c = i + 1 < n ? a + 2 : 1, d = i + 1 < n ? a + 3 : 0;
    strip.triangles.push_back({a, c, b});
    strip.triangles.push_back({b, c, d});
  }
  EXPECT_TRUE(repair(strip).one_sided);
  auto box = box_mesh({0, 0, 0}, {1, 1, 1});
  EXPECT_FALSE(repair(box).one_sided);
}

TEST(MeshFile, RepairingTwiceChangesNothing) {
  Random random(4, "mesh/twice");
  TriangleMesh soup;
  for (int i = 0; i < 60; ++i) soup.vertices.push_back(uniform3(random, 1));
  for (int i = 0; i < 10; ++i) soup.vertices.push_back(soup.vertices[random.below(60)]);
  for (int i = 0; i < 200; ++i) {
    std::array<std::uint32_t, 3> t;
    for (auto& c : t) c = static_cast<std::uint32_t>(random.below(70));
    soup.triangles.push_back(t);
  }
  repair(soup);
  const auto once = soup;
  const auto again = repair(soup);
  EXPECT_EQ(again.welded_vertices + again.dropped_triangles + again.repeated_triangles, 0u);
  EXPECT_EQ(soup.vertices, once.vertices);
}

TEST(MeshFile, CutOffAnywhereItIsReadOrRefusedInOneLine) {
  const auto mesh = box_mesh({0, 0, 0}, {1, 2, 3});
  for (const auto& [name, content] : every_format(mesh)) {
    int refused = 0;
    for (std::size_t size = 0; size < content.size(); ++size) {
      const auto file = parse_mesh(std::string_view(content).substr(0, size), name, 0.001);
      if (file) continue;
      ++refused;
      ASSERT_EQ(file.error().message.find('\n'), std::string::npos);
      ASSERT_EQ(file.error().message.find(name), 0u) << file.error().message;
    }
    // OBJ has no end that could be missing.
    if (std::string_view(name) != "mesh.obj") {
      EXPECT_GE(refused, static_cast<int>(content.size()) - 8) << name;
    }
  }
}

TEST(MeshFile, WhatIsWrongIsNamedWithItsPlaceAndRemedy) {
  const auto box = box_mesh({0, 0, 0}, {1, 1, 1});
  auto infinite = box, far = box;
  infinite.vertices[2].y() = HUGE_VAL;
  far.vertices[2].y() = 1e12;
  auto many = binary_stl(box);
  many[83] = '\x7f';
  const auto ply_of = [](std::string_view faces) {
    return "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
           "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n" +
           std::string(faces) + "\n";
  };
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"", "is empty; STL, OBJ or PLY is expected"},
      {"hello\n", "is no mesh; STL, OBJ or PLY is expected"},
      {binary_stl(infinite), "finite numbers are expected, repair or remove it"},
      {binary_stl(far), "1e+08 m is expected; check the unit"},
      {many, "says it holds 2130706444 triangles, at most 20000000 are expected; make it coarser"},
      {text_stl(box).substr(0, 400), "without endsolid; it is cut off, copy it again"},
      {"solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 zero\n", ":4: 'zero' is no coordinate"},
      {"solid\nfacet normal 0 0 1\nvertex 0 0 0\nendfacet\nendsolid\n",
       ":4: 'endfacet' where a facet of three"},
      {"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n", ":4: corner '4' of a face; 1 to 3 is expected"},
      {"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 0\n", ":4: corner '0' of a face"},
      {"v 0 0 0\nv 1 0 0\nv 0 1 0\nf -4 2 1\n", ":4: corner '-4' of a face"},
      {"v 0 0 0\nv 1 0 0\nf 1 2\n", ":3: a face of 2 corners; at least 3 are expected"},
      {"v 0 0\n", ":1: '' is no coordinate"},
      {"v 0 0 0\ncurv 1 2\n", ":2: 'curv' is not read here"},
      {"v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n", "holds 1 triangle, none with an area"},
      {"v 0 0 0\n", "holds 0 triangles, none with an area"},
      {ply_of("3 0 1 3"), "face 1 has the corner 3; 0 to 2 is expected"},
      {ply_of("3 0 1 -1"), "face 1 has the corner -1"},
      {ply_of("3 0 1 0.5"), "face 1 has the corner 0.5"},
      {ply_of("2 0 1"), "face 1 has 2 corners"},
      {ply_of("3 0 1"), "element 'face' 1 of 1 is cut off"},
      {"ply\nformat binary_big_endian 1.0\n",
       ":2: format 'binary_big_endian'; ascii or binary_little_endian"},
      {"ply\nformat ascii 1.0\nelement vertex 99999999999\n", "make it coarser"},
      {"ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n0\n",
       "its vertices have 1 of"},
      {"ply\nformat ascii 1.0\nelement nothing 60000000\nend_header\n", "has no properties"},
  };
  for (const auto& [content, message] : cases) {
    const auto file = parse_mesh(content, "thing", 1.0);
    ASSERT_FALSE(file) << message;
    EXPECT_NE(file.error().message.find(message), std::string::npos)
        << "expected: " << message << "\n     got: " << file.error().message;
  }
  const auto missing = read_mesh("/nowhere/thing.stl", 1.0);
  ASSERT_FALSE(missing);
  EXPECT_NE(missing.error().message.find("thing.stl"), std::string::npos);
  const auto cut = parse_mesh(binary_stl(box).substr(0, 300), "thing.stl", 1.0);
  EXPECT_NE(cut.error().message.find("12 triangles, which take 684 bytes, but has 300; copy it again"),
            std::string::npos)
      << cut.error().message;
}

}  // namespace
}  // namespace palpate::scene
