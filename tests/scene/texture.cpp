#include "gmis/scene/texture.hpp"

#include <cmath>
#include <limits>
#include <memory>
#include <random>

#include "support/catch.hpp"
#include "support/seed.hpp"

using namespace gmis;
using namespace gmis::scene;

namespace {

using Tex = Texture<float>;

std::shared_ptr<const TextureImage> random_image(int width, int height, std::mt19937_64& random) {
  auto image = std::make_shared<TextureImage>();
  image->resolution = {width, height};
  std::uniform_real_distribution<float> value(0, 1);
  for (int i = 0; i < width * height * 3; ++i) image->floats.push_back(value(random));
  return image;
}

/// Bilinear interpolation from its definition: every texel of nine copies of the image side by
/// side, times the product of two hats of its size.
glm::dvec3 interpolated(const TextureImage& image, double s, double t, TextureWrap wrap) {
  const int w = image.resolution.x, h = image.resolution.y;
  glm::dvec3 sum(0);
  for (int row = -2 * h; row < 3 * h; ++row)
    for (int column = -2 * w; column < 3 * w; ++column) {
      const double x = std::abs(s * w - (column + 0.5)), y = std::abs((1 - t) * h - (row + 0.5));
      if (x >= 1 || y >= 1) continue;
      const bool is_inside = column >= 0 && column < w && row >= 0 && row < h;
      if (wrap == TextureWrap::black && !is_inside) continue;
      const auto in = [&](int i, int size) {
        if (wrap == TextureWrap::mirror) {
          const int place = ((i % (2 * size)) + 2 * size) % (2 * size);
          return place < size ? place : 2 * size - 1 - place;
        }
        return wrap == TextureWrap::repeat ? ((i % size) + size) % size : std::min(std::max(i, 0), size - 1);
      };
      sum += glm::dvec3(image.texel(in(column, w), in(row, h))) * ((1 - x) * (1 - y));
    }
  return sum;
}

}  // namespace

TEST_CASE("an image is interpolated between the middles of its texels, and goes on beyond its border as it says") {
  std::mt19937_64 random(gmis_test::seed(301));
  std::uniform_real_distribution<double> coordinate(-1.4, 2.4);
  for (const auto& [width, height] : {std::pair{1, 1}, {2, 1}, {1, 3}, {4, 3}, {5, 8}}) {
    const auto image = random_image(width, height, random);
    for (const TextureWrap wrap : {TextureWrap::repeat, TextureWrap::clamp, TextureWrap::black, TextureWrap::mirror}) {
      const auto texture = Tex::image(image, {}, wrap);
      for (int i = 0; i < 200; ++i) {
        const glm::vec2 uv(static_cast<float>(coordinate(random)), static_cast<float>(coordinate(random)));
        CAPTURE(width, height, int(wrap), uv.x, uv.y);
        const glm::dvec3 expected = interpolated(*image, double(uv.x), double(uv.y), wrap);
        const glm::vec3 found = texture->at(uv);
        for (int c = 0; c < 3; ++c) {
          CHECK(double(found[c]) == Approx(expected[c]).margin(2e-5));
          CHECK(found[c] >= texture->lower()[c] - 1e-6F);
          CHECK(found[c] <= texture->upper()[c] + 1e-6F);
        }
      }
    }
  }
}

TEST_CASE("the lower left corner of an image is (0, 0), rows are stored from the top, and grey is in all channels") {
  auto image = std::make_shared<TextureImage>();
  image->resolution = {2, 2};
  image->channels = 1;
  image->bytes = {0, 85, 170, 255};
  for (std::size_t i = 0; i < 256; ++i) image->decoded[i] = static_cast<float>(i) / 255;
  const auto near = Tex::image(image, {}, TextureWrap::repeat, TextureFilter::nearest);
  CHECK(near->at({0.1F, 0.1F}) == glm::vec3(170.0F / 255));
  CHECK(near->at({0.9F, 0.1F}) == glm::vec3(1));
  CHECK(near->at({0.1F, 0.9F}) == glm::vec3(0));
  CHECK(near->at({-0.1F, 1.9F}) == glm::vec3(85.0F / 255));
  CHECK(near->mean().x == Approx(0.5));
  const auto inverted = Tex::image(image, {}, TextureWrap::repeat, TextureFilter::nearest, true);
  CHECK(inverted->at({0.1F, 0.1F}).x == Approx(1 - 170.0 / 255));
  CHECK(inverted->lower() == glm::vec3(0));
  CHECK(inverted->upper() == glm::vec3(1));
  const auto twice = Tex::image(image, {{2, 1}, {0.5, 0}}, TextureWrap::repeat, TextureFilter::nearest);
  CHECK(twice->at({0.3F, 0.1F}) == near->at({1.1F, 0.1F}));
}

TEST_CASE("checkerboards, products and mixtures are what they are of their parts") {
  const auto red = Tex::constant({1, 0, 0}), blue = Tex::constant({0, 0, 0.5});
  const auto board = Tex::checkerboard(red, blue, {{2, 2}, {0, 0}});
  CHECK(board->at({0.1F, 0.1F}) == glm::vec3(1, 0, 0));
  CHECK(board->at({0.6F, 0.1F}) == glm::vec3(0, 0, 0.5));
  CHECK(board->at({0.6F, 0.6F}) == glm::vec3(1, 0, 0));
  CHECK(board->at({-0.1F, 0.1F}) == glm::vec3(0, 0, 0.5));
  CHECK(board->at({-0.1F, -0.1F}) == glm::vec3(1, 0, 0));
  CHECK(board->mean() == glm::dvec3(0.5, 0, 0.25));
  CHECK_FALSE(board->is_constant());
  const auto half = Tex::product(board, Tex::constant(glm::dvec3(0.5)));
  CHECK(half->at({0.1F, 0.1F}) == glm::vec3(0.5, 0, 0));
  CHECK(half->upper() == glm::vec3(0.5, 0, 0.25));
  const auto mixed = Tex::mix(red, blue, Tex::constant(glm::dvec3(0.25)));
  CHECK(mixed->is_constant());
  CHECK(mixed->at({7, 7}) == glm::vec3(0.75, 0, 0.125));
  const auto varied =
      Tex::mix(red, blue, Tex::checkerboard(Tex::constant(glm::dvec3(0)), Tex::constant(glm::dvec3(3))));
  CHECK(varied->at({0.5F, 0.5F}) == glm::vec3(1, 0, 0));
  CHECK(varied->at({1.5F, 0.5F}) == glm::vec3(0, 0, 0.5));
  CHECK(Tex::product(red, blue)->is_constant());
}

TEST_CASE("coordinates that are huge or no numbers give a value of the image all the same") {
  std::mt19937_64 random(gmis_test::seed(302));
  const auto image = random_image(3, 2, random);
  constexpr float infinity = std::numeric_limits<float>::infinity();
  for (const TextureWrap wrap : {TextureWrap::repeat, TextureWrap::clamp, TextureWrap::black})
    for (const TextureFilter filter : {TextureFilter::bilinear, TextureFilter::nearest}) {
      const auto texture = Tex::image(image, {}, wrap, filter);
      const auto board = Tex::checkerboard(texture, Tex::constant(glm::dvec3(0.5)));
      for (const float x : {1e30F, -1e30F, 16777217.5F, infinity, -infinity, std::nanf(""), -1e-30F, 1.0F, 0.0F})
        for (const auto& one : {texture, board}) {
          const glm::vec3 value = one->at({x, 0.3F}) + one->at({0.3F, x});
          for (int c = 0; c < 3; ++c) CHECK((value[c] >= 0 && value[c] <= 2));
        }
    }
}

TEST_CASE("images that are none are refused") {
  auto image = std::make_shared<TextureImage>();
  CHECK_THROWS_AS(Tex::image(image), std::invalid_argument);
  image->resolution = {1, 1};
  image->floats = {0, std::nanf(""), 0};
  CHECK_THROWS_AS(Tex::image(image), std::invalid_argument);
  image->floats = {0, 1e38F, 0};
  CHECK_THROWS_AS(Tex::image(image), std::invalid_argument);
}

TEST_CASE("a texture looked up through another one, a cut, and how often parts are looked up") {
  auto image = std::make_shared<TextureImage>();
  image->resolution = {2, 2};
  image->channels = 1;
  image->floats = {0.1F, 0.2F, 0.3F, 0.4F};
  const auto inner = Tex::image(image, {}, TextureWrap::clamp);
  const auto swapped = Tex::mix(Tex::constant({0.25, 0.75, 0}), Tex::constant({0.5, 0.5, 0}), Tex::image(image));
  const auto through = Tex::through(swapped, inner);
  for (const float u : {0.0F, 0.3F, 0.9F}) CHECK(through->at({u, u}) == inner->at(glm::vec2(swapped->at({u, u}))));
  CHECK(through->upper() == inner->upper());
  const auto cut = Tex::threshold(inner, 0.25);
  for (const float u : {0.0F, 0.2F, 0.4F, 0.6F, 0.8F, 1.0F})
    CHECK(cut->at({u, 0.5F}).x == (inner->at({u, 0.5F}).x >= 0.25F ? 1.0F : 0.0F));
  CHECK(Tex::threshold(inner, 0.05)->is_constant());
  CHECK(inner->size() == 1);
  auto doubled = Tex::product(inner, inner);
  CHECK(doubled->size() == 3);
  for (int i = 0; i < 40; ++i) doubled = Tex::mix(doubled, doubled, inner);
  CHECK(doubled->size() > 1e12);
}
