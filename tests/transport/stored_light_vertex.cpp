#include "gmis/transport/photons/stored_light_vertex.hpp"

#include "gmis/scene.hpp"
#include "gmis/transport/engine/engine.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"

using namespace gmis;
using namespace gmis::scene;

namespace {

using Sc = BvhScene<float>;
using Context = Engine<Sc>::Context;
using Vertex = LightVertex<Sc, Context::Recursion>;
using Stored = Context::StoredVertex;

static_assert(BsdfWithCompactForm<SurfaceBsdf<float>> && BsdfWithCompactForm<SurfaceBsdf<double>>);

/// Has the compact form of its base, which would lose `more`.
struct DerivedBsdf : SurfaceBsdf<float> {
  using SurfaceBsdf<float>::SurfaceBsdf;
  int more = 0;
};
static_assert(Bsdf<DerivedBsdf> && !BsdfWithCompactForm<DerivedBsdf>);

Vec3<float> direction(Philox& source) {
  const float u = uniform<float>(source);
  return square_to_sphere(Vec2<float>(u, uniform<float>(source)));
}

TEST_CASE("a light vertex is kept in 96 bytes", "[light vertices]") {
  if constexpr (sizeof(void*) == 8) CHECK(sizeof(Stored) <= 96);
  CHECK(sizeof(Stored) < sizeof(Vertex));
}

TEST_CASE("a light vertex that is kept has all that it had", "[light vertices]") {
  Philox source(gmis_test::seed(1));
  const std::vector<Material<float>> materials{make_diffuse({.5, .2, .1}),
                                               make_phong({.3, .2, .1}, {.4, .4, .4}, 90),
                                               make_conductor({.2, .9, 1.1}, {3.9, 2.4, 2.1}, .2),
                                               make_coated_diffuse({.5, .5, .4}, 1.5, .1),
                                               make_dielectric(1.5, .3),
                                               make_diffuse_transmission({.4, .3, .2}, {.1, .2, .3})};
  const HalfPath scattered = HalfPath().then(PathEvent::glossy).then(PathEvent::specular).then(PathEvent::glossy);
  const std::vector<HalfPath> paths{HalfPath(), HalfPath().then(PathEvent::specular),
                                    HalfPath().then(PathEvent::diffuse), scattered,
                                    scattered.then(PathEvent::specular)};
  int compared = 0;
  for (const auto& material : materials)
    for (int i = 0; i < 200; ++i) {
      const Vec3<float> normal = direction(source);
      const Vec3<float> shading = i % 2 == 0 ? normal : glm::normalize(normal + 0.3F * direction(source));
      const SurfaceBsdf<float> bsdf(material, normal, shading);
      const auto exponent = static_cast<std::int32_t>(uniform_index(source, 4000)) - 2000;
      const auto vertex_sum = Extended<float>::of(0.5F + uniform<float>(source), i % 3 == 0 ? 0 : exponent);
      const Vertex vertex{{direction(source), normal, shading, 1e-6F},
                          bsdf,
                          direction(source),
                          Vec3<float>(uniform<float>(source)),
                          {vertex_sum, i % 5 == 0 ? Extended<float>() : vertex_sum * vertex_sum},
                          {0.5F, 0.25F},
                          static_cast<std::int16_t>(57 + i),  // up to 256
                          i % 2 == 1,
                          static_cast<std::uint16_t>(65535 - 300 * i),
                          paths[static_cast<std::size_t>(i) % paths.size()]};
      const Stored kept(vertex);
      CHECK(kept.point.position == vertex.point.position);
      CHECK(kept.point.geometric_normal == normal);
      CHECK(kept.point.shading_normal == shading);
      CHECK(kept.point.position_error == vertex.point.position_error);
      CHECK(kept.to_prev == vertex.to_prev);
      CHECK(kept.throughput == vertex.throughput);
      CHECK(kept.depth() == vertex.depth);
      CHECK(kept.is_photon() == vertex.is_photon);
      CHECK(kept.path() == vertex.path);
      CHECK(kept.light_group() == vertex.light_group);
      for (const auto part : {&PartialWeights<float>::shared, &PartialWeights<float>::chain}) {
        CHECK((kept.weights().*part).mantissa() == (vertex.weights.*part).mantissa());
        CHECK((kept.weights().*part).exponent() == (vertex.weights.*part).exponent());
      }
      const auto& again = kept.bsdf();
      CHECK(again.albedo() == bsdf.albedo());
      for (int k = 0; k < 5; ++k) {
        const Vec3<float> in = direction(source), out = direction(source);
        const auto expected = bsdf.evaluate(in, out, TransportMode::importance);
        const auto found = again.evaluate(in, out, TransportMode::importance);
        CHECK(found.value == expected.value);
        CHECK(found.pdf.forward.value == expected.pdf.forward.value);
        CHECK(found.pdf.reverse.value == expected.pdf.reverse.value);
        compared += max_channel(expected.value) > 0 ? 1 : 0;
      }
    }
  CHECK(compared > 500);
}

}  // namespace
