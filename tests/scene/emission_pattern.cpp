#include "gmis/scene/emission_pattern.hpp"

#include <algorithm>
#include <cstdlib>
#include <glm/geometric.hpp>
#include <glm/vector_relational.hpp>
#include <memory>
#include <random>

#include "gmis/scene/scene_builder.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"

// Area lights whose radiance varies over the surface, against sums over the texels of their image.

using namespace gmis::scene;
using Tex = Texture<float>;
using gmis::Vec2;
using gmis::Vec3;

namespace {

constexpr int side = 8;

std::shared_ptr<TextureImage> spotted(unsigned seed) {
  auto image = std::make_shared<TextureImage>();
  image->resolution = {side, side};
  std::mt19937 random(seed);
  for (int i = 0; i < side * side; ++i) {
    const bool shines = random() % 3 == 0;
    for (int c = 0; c < 3; ++c) image->floats.push_back(shines ? static_cast<float>(random() % 1000) / 100 : 0.0F);
  }
  return image;
}

/// A square of two triangles in the plane z = 0, its coordinates those of the image, seen from
/// above.
BvhScene<float> square_light(const Tex::Handle& radiance, const Material<float>& material,
                             const glm::dvec3& factor = glm::dvec3(1)) {
  SceneBuilder<float> builder;
  const std::vector<glm::dvec3> positions{{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
  const std::vector<glm::dvec2> uv{{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  const std::vector<std::array<int, 3>> triangles{{0, 1, 2}, {0, 2, 3}};
  builder.add_mesh({positions, triangles, {}, uv}, builder.add_material(material), AreaEmission{factor}, radiance);
  CameraDescription camera;
  camera.world_from_camera = glm::dmat4(1);
  camera.world_from_camera[3] = glm::dvec4(0, 0, 5, 1);
  camera.window = {-1, 1, -1, 1};
  camera.resolution = {4, 4};
  builder.set_camera(camera);
  return builder.build();
}

gmis::Ray<float> down_at(double x, double y) {
  return {{static_cast<float>(x), static_cast<float>(y), -3}, {0, 0, -1}, 100};
}

}  // namespace

TEST_CASE("a light shows the image that it has, times its radiance") {
  const auto image = spotted(static_cast<unsigned>(gmis_test::seed(361)));
  const auto texture = Tex::image(image, {}, TextureWrap::clamp, TextureFilter::nearest);
  const auto scene = square_light(texture, make_diffuse({0.5, 0.5, 0.5}), {1, 2, 4});
  glm::dvec3 brightest(0);
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) {
      const glm::dvec3 wanted = glm::dvec3(image->texel(x, y)) * glm::dvec3(1, 2, 4);
      brightest = glm::max(brightest, wanted);
      const auto hit = scene.intersect(down_at(-1 + 2 * (x + 0.4) / side, 1 - 2 * (y + 0.6) / side));
      REQUIRE(hit);
      const auto found =
          hit->light == nullptr ? gmis::Vec3<float>(0) : hit->light->emitted(hit->point, {0, 0, 1}).radiance;
      CHECK(glm::length(glm::dvec3(found) - wanted) <= 1e-4 * (1 + glm::length(wanted)));
    }
  CHECK(brightest.x > 0);
}

TEST_CASE("next events and light subpaths carry the mean of the image", "[statistics]") {
  const auto seed = gmis_test::seed(362);
  const auto image = spotted(static_cast<unsigned>(seed));
  const auto scene =
      square_light(Tex::image(image, {}, TextureWrap::clamp, TextureFilter::nearest), make_diffuse({0.5, 0.5, 0.5}));
  glm::dvec3 mean(0);
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) mean += glm::dvec3(image->texel(x, y)) / double(side * side);
  // Irradiance-like sum far away on the axis, by the midpoint rule over texels; and flux = π · area
  // · mean.
  const gmis::SurfacePoint<float> from{{0, 0, 20}, {0, 0, -1}, {0, 0, -1}, 0};  // 25 before the light
  std::mt19937_64 random(static_cast<std::mt19937_64::result_type>(seed));
  std::uniform_real_distribution<float> uniform(0, 1);
  constexpr int count = 200'000;
  glm::dvec3 direct(0), direct_square(0), flux(0), flux_square(0);
  for (int i = 0; i < count; ++i) {
    const auto choice = scene.sample_light(uniform(random));
    const Vec2<float> uv(uniform(random), uniform(random)), uv2(uniform(random), uniform(random));
    if (const auto next = choice.light->sample_next_event(from, uv)) {
      const glm::dvec3 value = glm::dvec3(next->weight) / double(choice.selection_probability);
      direct += value, direct_square += value * value;
      // The same colour as that which a ray finds there.
      const glm::dvec3 seen(choice.light->emitted(next->origin, -next->to_light).radiance);
      REQUIRE(glm::length(glm::cross(value, seen)) <= 1e-5 * glm::length(value) * glm::length(seen));
    }
    if (const auto start = choice.light->sample_emission(uv, uv2)) {
      const glm::dvec3 value = glm::dvec3(start->weight) / double(choice.selection_probability);
      flux += value, flux_square += value * value;
    }
  }
  glm::dvec3 wanted(0);
  constexpr int steps = 16;  // a texel
  for (int y = 0; y < side * steps; ++y)
    for (int x = 0; x < side * steps; ++x) {
      const double n = side * steps, px = -1 + 2 * (x + 0.5) / n, py = 1 - 2 * (y + 0.5) / n;
      const double d2 = px * px + py * py + 625;
      wanted += glm::dvec3(image->texel(x / steps, y / steps)) * (25 / std::sqrt(d2)) / d2 * (4 / (n * n));
    }
  // Six z-tests: 5 standard deviations are a false alarm in 290,000.
  const auto agrees = [](double sum, double squares, double exact) {
    const double found = sum / count, error = std::sqrt(std::max(0.0, squares / count - found * found) / count);
    CAPTURE(found, error, exact);
    CHECK(std::abs(found - exact) <= 5 * error + 1e-4 * exact);
  };
  for (int c = 0; c < 3; ++c) {
    agrees(direct[c], direct_square[c], wanted[c]);
    agrees(flux[c], flux_square[c], gmis::pi<double> * 4 * mean[c]);
  }
}

TEST_CASE("a triangle that is black all over is no light, one that shines somewhere is") {
  auto image = std::make_shared<TextureImage>();
  image->resolution = {64, 64};
  image->floats.assign(3 * 64 * 64, 0.0F);
  const auto at = [&](int x, int y) { return static_cast<std::size_t>(3 * (64 * y + x)); };
  CHECK(square_light(Tex::image(image), make_diffuse({0.5, 0.5, 0.5})).lights().empty());
  image->floats[at(60, 40)] = 1;  // one texel, in the lower right triangle
  const auto scene = square_light(Tex::image(image), make_diffuse({0.5, 0.5, 0.5}));
  REQUIRE(scene.lights().size() >= 1);
  CHECK(scene.lights()[0].power() > 0);
}

TEST_CASE("a light with holes shines where it is") {
  auto half = std::make_shared<TextureImage>();
  half->resolution = {2, 1};
  half->channels = 1;
  half->floats = {0, 1};
  MaterialTextures<float> textures;
  textures.opacity = Tex::image(half, {}, TextureWrap::clamp, TextureFilter::nearest);
  const auto scene = square_light(nullptr, with_textures(make_diffuse({0.5, 0.5, 0.5}), textures), {3, 3, 3});
  REQUIRE(scene.lights().size() == 2);
  const gmis::SurfacePoint<float> from{{0, 0, 1}, {0, 0, -1}, {0, 0, -1}, 0};
  std::mt19937 random(static_cast<std::mt19937::result_type>(gmis_test::seed(363)));
  std::uniform_real_distribution<float> uniform(0, 1);
  for (int i = 0; i < 1000; ++i)
    for (const auto& light : scene.lights()) {
      const auto next = light.sample_next_event(from, {uniform(random), uniform(random)});
      REQUIRE(next);
      CHECK((next->weight.x > 0) == (next->origin.position.x > 0));
    }
  CHECK_FALSE(scene.intersect(down_at(-0.5, 0.1)));
  CHECK(scene.intersect(down_at(0.5, 0.1))->light != nullptr);
}

TEST_CASE("bounds over a rectangle hold and are tight for an image") {
  const auto image = spotted(static_cast<unsigned>(gmis_test::seed(364)));
  std::mt19937 random(static_cast<std::mt19937::result_type>(gmis_test::seed(365)));
  std::uniform_real_distribution<float> uniform(-2, 2);
  for (const TextureWrap wrap : {TextureWrap::repeat, TextureWrap::clamp, TextureWrap::black, TextureWrap::mirror}) {
    const auto texture = Tex::image(image, {{1, 1}, {0.1, 0.2}, {0.3, -0.2}}, wrap);
    for (int i = 0; i < 300; ++i) {
      const Vec2<float> a(uniform(random), uniform(random)), b(uniform(random), uniform(random));
      const auto low = glm::min(a, b), high = glm::max(a, b);
      const auto upper = texture->upper_between(low, high);
      CHECK(glm::all(glm::lessThanEqual(upper, texture->upper())));
      for (int k = 0; k < 20; ++k) {
        const Vec2<float> s((uniform(random) + 2) / 4, (uniform(random) + 2) / 4);
        const auto value = texture->at(low + (high - low) * s);
        for (int c = 0; c < 3; ++c) CHECK(value[c] <= upper[c] + 1e-5F);
      }
    }
  }
  // One bright texel, its middle at (60.5, 23.5) / 64: it is in the bounds of the texels beside it,
  // and in those of none that is more than three away.
  auto dark = std::make_shared<TextureImage>();
  dark->resolution = {64, 64};
  dark->channels = 1;
  dark->floats.assign(64 * 64, 0.0F);
  dark->floats[64 * 40 + 60] = 1;
  const auto texel = Tex::image(dark, {}, TextureWrap::clamp), grey = Tex::constant(glm::dvec3(0.25));
  const auto product = Tex::product(grey, texel), mix = Tex::mix(grey, texel, texel);
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 64; ++x) {
      const auto middle = (Vec2<float>(static_cast<float>(x), static_cast<float>(y)) + 0.5F) / 64.0F;
      const auto low = middle - 0.001F, high = middle + 0.001F;
      const float upper = texel->upper_between(low, high).x;
      const int off = std::max(std::abs(x - 60), std::abs(y - 23));
      CHECK(((off > 1 && upper == 0) || (off <= 3 && upper == 1)));
      CHECK(product->upper_between(low, high).x == 0.25F * upper);
      CHECK(mix->upper_between(low, high).x == std::max(0.25F, upper));
    }
}
