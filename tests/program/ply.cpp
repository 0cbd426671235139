#include "support/ply_mesh.hpp"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <fstream>
#include <random>
#include <string>

#include "program/scratch_folder.hpp"
#include "support/catch.hpp"
#include "support/message_of.hpp"
#include "support/read_file.hpp"
#include "support/seed.hpp"

#if GMIS_HAS_ZLIB
#include <zlib.h>
#endif

// PLY files as they are read: against the numbers that they were written from.

using namespace gmis::tools;
using gmis_test::ScratchFolder;

namespace {

MeshDescription parsed(const std::string& content) {
  LoadBudget budget;
  return parse_ply(content, "the mesh", budget, {});
}

/// Empty when it is read.
std::string error_of(const std::string& content) {
  return gmis_test::message_of<InputError>([&] { return parsed(content); });
}

template <class Number>
std::string bytes_of(Number value, bool is_big) {
  std::string bytes(reinterpret_cast<const char*>(&value), sizeof value);
  if (is_big == (std::endian::native == std::endian::little)) std::reverse(bytes.begin(), bytes.end());
  return bytes;
}

}  // namespace

TEST_CASE("Binary meshes are read whatever their first byte, byte order and line ends are") {
  for (const std::string end : {"\n", "\r\n", "\r"})
    for (const bool is_big : {false, true})
      for (unsigned byte = 0; byte < 256; ++byte) {
        // The first byte of x is any; the exponent keeps it a number.
        std::uint32_t bits = is_big ? byte << 24U | 0x1234U : 0x3F400000U | byte;
        if (is_big && (byte & 0x7FU) == 0x7FU) bits &= ~0x00800000U;
        const auto x = std::bit_cast<float>(bits);
        std::string content;
        for (const char* line : {"ply", is_big ? "format binary_big_endian 1.0" : "format binary_little_endian 1.0",
                                 "comment end_header is not here", "element vertex 3", "property float x",
                                 "property float y", "property float z", "property uchar red", "property double nx",
                                 "property double ny", "property double nz", "property float s", "property float t",
                                 "element face 1", "property list uchar int vertex_indices", "end_header"})
          content += line + end;
        for (int i = 0; i < 3; ++i) {
          content += bytes_of(i == 0 ? x : static_cast<float>(i), is_big) +
                     bytes_of(static_cast<float>(i * i), is_big) + bytes_of(0.5F, is_big) + 'r';
          for (int axis = 0; axis < 3; ++axis) content += bytes_of(axis == 2 ? 1.0 : 0.0, is_big);
          content += bytes_of(0.25F, is_big) + bytes_of(0.75F, is_big);
        }
        content += '\x03' + bytes_of(0, is_big) + bytes_of(1, is_big) + bytes_of(2, is_big);
        CAPTURE(end, is_big, byte);
        const MeshDescription mesh = parsed(content);
        REQUIRE(mesh.positions.size() == 3);
        CHECK(mesh.positions[0] == Point(static_cast<double>(x), 0, 0.5));
        CHECK(mesh.positions[2] == Point(2, 4, 0.5));
        CHECK(mesh.normals.at(1) == glm::dvec3(0, 0, 1));
        CHECK(mesh.uv.at(2) == glm::dvec2(0.25, 0.75));
        CHECK(mesh.triangles == std::vector<std::array<int, 3>>{{0, 1, 2}});
      }
}

TEST_CASE("Every type of number is read, and polygons are cut into fans") {
  std::mt19937 random(static_cast<std::mt19937::result_type>(gmis_test::seed(371)));
  for (const bool is_big : {false, true})
    for (int round = 0; round < 20; ++round) {
      std::string content =
          std::string("ply\nformat binary_") + (is_big ? "big" : "little") +
          "_endian 1.0\nelement vertex 5\nproperty char x\nproperty ushort y\nproperty int z\n"
          "element face 2\nproperty list ushort short vertex_index\nelement other 1\nproperty list uint "
          "double weights\nend_header\n";
      std::vector<Point> wanted;
      for (int i = 0; i < 5; ++i) {
        const auto x = static_cast<std::int8_t>(random());
        const auto y = static_cast<std::uint16_t>(random());
        const auto z = static_cast<std::int32_t>(random());
        content += bytes_of(x, is_big) + bytes_of(y, is_big) + bytes_of(z, is_big);
        wanted.emplace_back(x, y, z);
      }
      for (const int corners : {5, 2}) {
        content += bytes_of(static_cast<std::uint16_t>(corners), is_big);
        for (int k = 0; k < corners; ++k) content += bytes_of(static_cast<std::int16_t>(k), is_big);
      }
      content += bytes_of(std::uint32_t{1}, is_big) + bytes_of(0.5, is_big);
      const MeshDescription mesh = parsed(content);
      CHECK(mesh.positions == wanted);
      CHECK(mesh.triangles == std::vector<std::array<int, 3>>{{0, 1, 2}, {0, 2, 3}, {0, 3, 4}});
    }
}

TEST_CASE("The corners of a long list are counted before there is memory for them") {
  constexpr std::uint32_t corners = 1'000'000;
  const std::string content =
      "ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n"
      "element face 1\nproperty list uint uchar vertex_indices\nend_header\n" +
      std::string(12, '\0') + bytes_of(corners, false) + std::string(corners, '\0');
  LoadBudget room(std::uintmax_t{64} << 20);
  CHECK(parse_ply(content, "the mesh", room, {}).triangles.size() == corners - 2);
  // 8 bytes for each corner, 32 and 12 for each triangle.
  CHECK(room.taken() >= corners * 52ULL - 200);
  CHECK(room.taken() <= corners * 52ULL + 200);
  LoadBudget small(std::uintmax_t{32} << 20), smaller(std::uintmax_t{4} << 20);
  CHECK_THROWS_WITH(parse_ply(content, "the mesh", small, {}), Catch::Contains("--max-memory"));
  CHECK_THROWS_WITH(parse_ply(content, "the mesh", smaller, {}), Catch::Contains("the mesh would take 7.6 MiB"));
}

#if GMIS_HAS_ZLIB

TEST_CASE("A packed mesh is unpacked in memory, and a bomb is stopped before it fills it") {
  const ScratchFolder folder;
  const auto packed = [&](const std::string& name, const std::string& content, std::size_t zeros) {
    const gzFile file = gzopen((folder.path / name).c_str(), "wb1");
    gzwrite(file, content.data(), static_cast<unsigned>(content.size()));
    const std::string block(std::size_t{1} << 20, '\0');
    for (std::size_t i = 0; i < zeros; ++i) gzwrite(file, block.data(), static_cast<unsigned>(block.size()));
    gzclose(file);
  };
  const std::string mesh =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
      "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n2 0 0\n2 2 0\n3 0 1 2\n";
  packed("a.ply.gz", mesh, 0);
  LoadBudget budget;
  CHECK(read_ply(folder.path / "a.ply.gz", budget, {}).triangles.size() == 1);
  packed("A.PLY.GZ", mesh, 0);
  CHECK(read_ply(folder.path / "A.PLY.GZ", budget, {}).triangles.size() == 1);
  packed("bomb.ply.gz", mesh, 48);
  LoadBudget small(std::uintmax_t{8} << 20);
  CHECK_THROWS_WITH(read_ply(folder.path / "bomb.ply.gz", small, {}), Catch::Contains("--max-memory"));
  CHECK(small.taken() <= std::uintmax_t{8} << 20);
  std::string broken = gmis_test::text_of(folder.path / "a.ply.gz");
  broken.resize(broken.size() - 5);
  std::ofstream(folder.path / "broken.ply.gz", std::ios::binary) << broken;
  CHECK_THROWS_WITH(read_ply(folder.path / "broken.ply.gz", budget, {}), Catch::Contains("no whole gzip"));
}

#endif

TEST_CASE("A PLY file cut short or with bytes changed gives an error or a mesh, never a crash") {
  const std::string text =
      "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
      "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
      "0 0 0\n2 0 0\n2 2 0\n0 2 0\n4 0 1 2 3\n";
  const auto is_read = [&](const std::string& content) {
    try {
      const MeshDescription mesh = parsed(content);
      for (const auto& triangle_corners : mesh.triangles)
        for (const int index : triangle_corners) CHECK(static_cast<std::size_t>(index) < mesh.positions.size());
      return true;
    } catch (const InputError&) {
      return false;
    }
  };
  CHECK(is_read(text));
  for (std::size_t length = 0; length + 30 < text.size(); ++length) {
    CAPTURE(length);
    CHECK_FALSE(is_read(text.substr(0, length)));
  }
  const std::size_t data = text.find("end_header") + 11;
  std::mt19937 random(gmis_test::seed(1));
  for (int round = 0; round < 300; ++round) {
    std::string broken = text;
    broken[data + random() % (broken.size() - data)] = static_cast<char>(random() % 256U);
    (void)is_read(broken);
    broken[random() % data] = static_cast<char>(random() % 256U);
    (void)is_read(broken);
  }
}

TEST_CASE("An error in a PLY file says what to do, and names the face") {
  const auto error_with = [](const std::string& faces, int count) {
    return error_of(
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
        "element face " +
        std::to_string(count) + "\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n2 0 0\n2 2 0\n" + faces);
  };
  CHECK_THAT(error_with("4 0 1 2 0\n3 0 1 3\n", 2), Catch::Contains("its face 1 (counted from 0) refers to a vertex"));
  CHECK_THAT(error_with("", 0), Catch::Contains("no triangle: export it with its faces"));
  CHECK_THAT(error_of("solid"), Catch::Contains("export or copy it again"));
}

TEST_CASE("PLY files whose lists or counts lie about their length are refused") {
  const auto is_whole = [&](const std::string& content) {
    return error_of(content).find("is incomplete") == std::string::npos;
  };
  const auto text_with = [](const std::string& faces, int count) {
    return "ply\nformat ascii 1.0\ncomment made by hand\nelement vertex 4\nproperty float x\nproperty float y\n"
           "property float z\nelement face " +
           std::to_string(count) +
           "\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n2 0 0\n2 2 0\n0 2 0\n" + faces;
  };
  CHECK(is_whole(text_with("4 0 1 2 3\n", 1)));
  CHECK(is_whole(text_with("3 0 1 2\r\n\r\n 3 0 2 3 \r\n", 2)));
  CHECK_FALSE(is_whole(text_with("3 0 1 2\n", 2)));           // one face too few
  CHECK_FALSE(is_whole(text_with("4 0 1 2\n3 0 1 2\n", 2)));  // a list that takes from the next one
  CHECK_FALSE(is_whole(text_with("3 0 1 2 3\n", 1)));
  CHECK_FALSE(is_whole(text_with("4294967295 0 1 2\n", 1)));
  CHECK_FALSE(is_whole(text_with("-3 0 1 2\n", 1)));

  const auto number = [](auto value, bool is_big) {
    std::string bytes(reinterpret_cast<const char*>(&value), sizeof value);
    if (is_big == (std::endian::native == std::endian::little)) std::reverse(bytes.begin(), bytes.end());
    return bytes;
  };
  for (const bool is_big : {false, true}) {
    const auto binary_with = [&](std::int32_t length, int entries) {
      std::string content = std::string("ply\nformat ") + (is_big ? "binary_big_endian" : "binary_little_endian") +
                            " 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
                            "element face 1\nproperty uchar flags\nproperty list int int vertex_indices\nend_header\n";
      for (int i = 0; i < 9; ++i) content += number(static_cast<float>(i % 4), is_big);
      content += 'f' + number(length, is_big);
      for (int i = 0; i < entries; ++i) content += number(i, is_big);
      return content;
    };
    CHECK(is_whole(binary_with(3, 3)));
    CHECK_FALSE(is_whole(binary_with(4, 3)));
    CHECK_FALSE(is_whole(binary_with(0x7fffffff, 3)));
    CHECK_FALSE(is_whole(binary_with(-1, 3)));
    const std::string whole = binary_with(3, 3);
    for (std::size_t length = 0; length < whole.size(); ++length) {
      CAPTURE(is_big, length);
      CHECK_FALSE(is_whole(whole.substr(0, length)));
    }
  }
}
