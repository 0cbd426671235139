#include "gmis/check/check_scene.hpp"

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "adapters/planted_mistakes.hpp"
#include "bring_your_own/adapter.hpp"
#include "bring_your_own/world.hpp"
#include "gmis/check/explain.hpp"
#include "gmis/core/density_tests.hpp"
#include "gmis/core/scene_like.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"
#include "transport/furnace_scene.hpp"

using namespace gmis_test;

namespace {

/// A scene that states these effects, whatever it has.
class Stating : public gmis::SceneLike<adapter::Scene> {
 public:
  Stating(const adapter::Scene& scene, const gmis::Effects& stated) : SceneLike(scene), stated_(stated) {}
  [[nodiscard]] gmis::Effects effects() const { return stated_; }

 private:
  gmis::Effects stated_;
};
static_assert(gmis::SceneWithEffects<Stating>);

/// A ball of 2 · columns² triangles with the normals of the sphere.
template <class Builder>
void add_smooth_ball(Builder& builder, const glm::dvec3& center, double radius, int columns, std::size_t material) {
  std::vector<glm::dvec3> positions, normals;
  std::vector<std::array<int, 3>> triangles;
  for (int row = 0; row <= columns; ++row)
    for (int column = 0; column < columns; ++column) {
      const double polar = gmis::pi<double> * row / columns, turn = 2 * gmis::pi<double> * column / columns;
      normals.push_back({std::sin(polar) * std::cos(turn), std::sin(polar) * std::sin(turn), std::cos(polar)});
      positions.push_back(center + radius * normals.back());
      if (row == columns) continue;
      const int here = row * columns + column, beside = row * columns + (column + 1) % columns;
      if (row > 0) triangles.push_back({here, here + columns, beside});
      if (row + 1 < columns) triangles.push_back({beside, here + columns, beside + columns});
    }
  builder.add_mesh({positions, triangles, normals}, material);
}

}  // namespace

TEST_CASE("nothing is said about a sound scene") {
  CHECK(check_scene(built_in_scene<float>(), check_settings()).text() == "");
  CHECK(check_scene(built_in_scene<double>(), check_settings()).text() == "");
  CHECK(check_scene(gmis_test::FurnaceScene<float>(0.7F, 1.0F, 16, 2), check_settings()).text() == "");
  CHECK(check_scene(gmis_test::FurnaceScene<double>(0.5, 2.0, 16, 1), check_settings()).text() == "");
}

TEST_CASE("mirrors, glass and metals with smooth normals are sound") {
  // Balls of few faces, so that many rays leave between the two normals.
  for (const int columns : {6, 12}) {
    const auto scene = built_in_scene<float>([columns](auto& builder, std::size_t, std::size_t glass) {
      using namespace gmis::scene;
      const std::vector<std::size_t> materials{
          glass, builder.add_material(make_mirror<float>({0.9, 0.9, 0.9})),
          builder.add_material(make_dielectric<float>(1.4, 0.2)),
          builder.add_material(make_conductor_of_reflectance<float>({0.9, 0.7, 0.4}, 0.1))};
      for (std::size_t i = 0; i < materials.size(); ++i)
        add_smooth_ball(builder, {-2.4 + 1.6 * static_cast<double>(i), 1.2, 0.5}, 0.7, columns, materials[i]);
    });
    INFO(columns << " columns");
    CHECK(check_scene(scene, check_settings()).text() == "");
  }
}

TEST_CASE("a dark coat seen at grazing angles, thin leaves and a thinner sheet are sound") {
  using namespace gmis::scene;
  SceneBuilder<float> builder;
  const auto coated = builder.add_material(make_coated_diffuse<float>({0.02, 0.02, 0.02}, 1.5, 0.05));
  const auto leaf = builder.add_material(make_phong<float>({0.2, 0.5, 0.2}, {0.1, 0.1, 0.1}, 10));
  const std::vector<std::array<int, 3>> square{{0, 2, 1}, {0, 3, 2}};
  const std::vector<glm::dvec3> floor{{-20, 0, -20}, {20, 0, -20}, {20, 0, 20}, {-20, 0, 20}};
  builder.add_mesh({floor, square}, coated);
  // Lenses of two sides each, which meet at an edge, and their smooth normals.
  gmis::Philox source(gmis_test::seed(21));
  for (int i = 0; i < 400; ++i) {
    const auto coordinate = [&](double low, double high) { return low + (high - low) * gmis::uniform<double>(source); };
    const double x = coordinate(-1, 1), y = coordinate(0.2, 1), z = coordinate(-1, 1);
    const glm::dvec3 center(x, y, z);
    const double u = gmis::uniform<double>(source);
    const auto frame =
        gmis::Frame<double>::around(gmis::square_to_sphere(gmis::Vec2<double>(u, gmis::uniform<double>(source))));
    std::vector<glm::dvec3> positions, normals;
    std::vector<std::array<int, 3>> triangles;
    constexpr int corners = 6;
    for (const double side : {-1.0, 1.0}) {
      const int first = static_cast<int>(positions.size());
      positions.push_back(center + frame.to_world({0, 0, side * 0.0005}));
      normals.push_back(side * frame.normal);
      for (int k = 0; k < corners; ++k) {
        const double turn = 2 * gmis::pi<double> * k / corners;
        const glm::dvec3 outward(std::cos(turn), std::sin(turn), 0);
        positions.push_back(center + frame.to_world(0.05 * outward));
        normals.push_back(glm::normalize(frame.to_world(outward + side * glm::dvec3(0, 0, 0.4))));
        const int next = first + 1 + (k + 1) % corners, here = first + 1 + k;
        triangles.push_back(side > 0 ? std::array{first, here, next} : std::array{first, next, here});
      }
    }
    builder.add_mesh({positions, triangles, normals}, leaf);
  }
  const double thickness = 2e-5;
  const std::vector<glm::dvec3> above{{-3, 1.5, 1}, {3, 1.5, 1}, {3, 1.5, 4}, {-3, 1.5, 4}};
  std::vector<glm::dvec3> below = above;
  for (glm::dvec3& corner : below) corner.y -= thickness;
  builder.add_mesh({above, square}, leaf);
  builder.add_mesh({below, std::vector<std::array<int, 3>>{{0, 1, 2}, {0, 2, 3}}}, leaf);
  builder.add_environment({1, 1, 1});
  builder.set_camera(look_at({0, 0.3, -5}, {0, 0.4, 0}, {0, 1, 0}, 40, {64, 48}));
  const auto scene = builder.build();
  for (std::uint64_t i = 0; i < 4; ++i) {
    gmis::SceneCheckSettings settings = check_settings();
    settings.seed = gmis_test::seed(30 + i);
    CHECK(check_scene(scene, settings).text() == "");
  }
}

TEST_CASE("a surface of steps finer than the check looks is no wrong normal") {
  theirs::World world = theirs::make_world(64, 48);
  const auto carved = std::make_shared<theirs::Matt>(theirs::Vector{0.4, 0.4, 0.4});
  for (int i = 0; i < 120; ++i) {
    const double height = i % 2 == 0 ? 0.003 : 0.011;
    world.shapes.push_back({carved, nullptr, false, {-0.9 + 0.015 * i, height, -2}, {0, 0, 2}, {0.015, 0, 0}});
  }
  CHECK(check_scene(adapter::Scene(world), check_settings()).text() == "");
}

TEST_CASE("every planted mistake is named") {
  const auto scene = built_in_scene<float>();
  // The adapter itself changes nothing.
  CHECK(check_scene(BrokenScene(scene, Mistake::none), check_settings()).text() == "");
  CHECK(planted.size() >= 50);
  for (const Planted& one : planted) {
    const gmis::Findings findings = check_scene(BrokenScene(scene, one.mistake), check_settings());
    INFO("mistake " << static_cast<int>(one.mistake) << ", wanted: " << sentence_of(one.wanted));
    INFO("said:\n" << findings.text());
    const std::vector<gmis::Finding> broken = findings.broken();
    // The cause comes first, with an example.
    REQUIRE_FALSE(broken.empty());
    CHECK(broken.front().convention == one.wanted);
    CHECK(broken.front().example.has_value());
  }
}

TEST_CASE("effects that a scene has and does not state are named") {
  const theirs::World world = theirs::make_world(64, 48);
  const adapter::Scene scene(world);
  const gmis::Effects all = scene.effects();
  CHECK(check_scene(Stating(scene, all), check_settings()).text() == "");
  for (bool gmis::Effects::*const member :
       {&gmis::Effects::diffuse, &gmis::Effects::specular_transmission, &gmis::Effects::area_lights}) {
    gmis::Effects fewer = all;
    fewer.*member = false;
    const std::vector<gmis::Finding> broken = check_scene(Stating(scene, fewer), check_settings()).broken();
    REQUIRE_FALSE(broken.empty());
    CHECK(broken.front().convention == Convention::effects);
  }
}

TEST_CASE("one light is checked alone, and a direction of emission that is no unit vector is named") {
  const auto scene = built_in_scene<float>();
  // Places in the air, in the scene's own space, which has the camera at 0.
  std::vector<gmis::SurfacePoint<float>> receivers(3);
  receivers[0].position = {0.0F, -0.5F, 5.0F};
  receivers[1].position = {-1.0F, 0.0F, 4.5F};
  receivers[2].position = {0.0F, 0.5F, 4.0F};
  for (const Mistake mistake : {Mistake::none, Mistake::emission_direction_not_unit}) {
    const BrokenScene broken(scene, mistake);
    const auto* const light = broken.sample_light(0.5F).light;
    REQUIRE(light != nullptr);
    gmis::Philox source(gmis_test::seed(9));
    const gmis::Findings findings =
        gmis::check_light(broken, *light, std::span<const gmis::SurfacePoint<float>>(receivers), source);
    INFO(findings.text());
    CHECK(findings.passes() == (mistake == Mistake::none));
    if (!findings.passes()) CHECK(findings.broken().front().convention == Convention::emission_unit);
  }
}

TEST_CASE("what an adapter leaves out is listed, with what it costs") {
  CHECK(gmis::explain(built_in_scene<float>()) == "");
  const std::string furnace = gmis::explain(gmis_test::FurnaceScene<float>(0.7F, 1.0F, 16, 2));
  CHECK(furnace.find("Scene::effects() is missing") != std::string::npos);
  CHECK(furnace.find("BsdfWithLobes") == std::string::npos);
  const theirs::World world = theirs::make_world(8, 6);
  const std::string other = gmis::explain(adapter::Scene(world));
  CHECK(other.find("effects()") == std::string::npos);
  CHECK(other.find("light_group(light) is missing") != std::string::npos);
  CHECK(other.find("BsdfWithLobes") != std::string::npos);
  CHECK(other.find("is_glossy() is missing") != std::string::npos);
  const adapter::Scene scene(world);
  const std::string dark = gmis::explain(Stating(scene, {.diffuse = true}));
  CHECK(dark.find("names no light: the picture will be black") != std::string::npos);
  CHECK(dark.find("names every effect") == std::string::npos);
  const std::string everything = gmis::explain(Stating(scene, gmis::Effects::everything()));
  CHECK(everything.find("names every effect") != std::string::npos);
  CHECK(everything.find("names no light") == std::string::npos);
}

TEST_CASE("every convention has a sentence of its own") {
  for (std::size_t i = 0; i < gmis::convention_count; ++i) {
    const auto sentence = sentence_of(static_cast<Convention>(i));
    CHECK(sentence.size() > 40);
    for (std::size_t j = 0; j < i; ++j) CHECK(sentence != sentence_of(static_cast<Convention>(j)));
  }
  gmis::Findings findings;
  for (int i = 0; i < 100; ++i) findings.count(Convention::hit_range, i > 2);
  CHECK(findings.passes());  // 3 of 100 are rounding
  for (int i = 0; i < 10; ++i) findings.count(Convention::hit_range, false);
  CHECK_FALSE(findings.passes());
  CHECK(findings.text().find("t_max [13 of 110 cases]") != std::string::npos);
  findings.judge(Convention::bsdf_energy, true);
  CHECK(findings.broken().size() == 1);
}

TEST_CASE("an example says what is known of a case, and no more") {
  using gmis::FindingExample;
  CHECK(FindingExample{}.text() == "");
  CHECK(FindingExample{{1, 2, 3}, {}, {0, 0, 1}}.text() == "at (1, 2, 3), to_next (0, 0, 1)");
  CHECK(FindingExample{{1, 2, 3}, {0, 1, 0}, {}, 0.5, 0.25}.text() ==
        "at (1, 2, 3), to_prev (0, 1, 0): 0.5 in place of 0.25");
  CHECK(FindingExample{{}, {}, {}, 0.5, 1}.text() == "0.5 in place of 1");
  CHECK(FindingExample{{1, 2, 3}, {}, {}, 0, 0}.text() == "at (1, 2, 3)");
  gmis::Findings findings;
  findings.judge(Convention::bsdf_energy, false);
  CHECK(findings.text().find("example") == std::string::npos);
}

TEST_CASE("a BSDF that is made for one to_prev is checked with the to_prev of each ray") {
  // Cosine-weighted reflection around the normal on the side of `to_prev`, which the BSDF has
  // stored.
  struct OneSided {
    using Spectrum = float;
    gmis::Vec3<float> normal;
    [[nodiscard]] gmis::BsdfValue<float> evaluate(const gmis::Vec3<float>& to_prev, const gmis::Vec3<float>& to_next,
                                                  gmis::TransportMode) const {
      const float prev = glm::dot(to_prev, normal), next = glm::dot(to_next, normal);
      if (next <= 0) return {};
      return {0.5F / gmis::pi<float>, {{next / gmis::pi<float>}, {std::abs(prev) / gmis::pi<float>}}};
    }
    [[nodiscard]] std::optional<gmis::ScatterSample<float>> sample(const gmis::Vec3<float>& to_prev, float,
                                                                   const gmis::Vec2<float>& uv,
                                                                   gmis::TransportMode mode) const {
      const auto to_next = gmis::Frame<float>::around(normal).to_world(gmis::square_to_cosine_hemisphere(uv));
      const auto f = evaluate(to_prev, to_next, mode);
      if (!(f.pdf.forward.value > 0)) return std::nullopt;
      return gmis::ScatterSample<float>{to_next, 0.5F, f.pdf, false, 1.0F};
    }
    [[nodiscard]] bool is_purely_delta() const { return false; }
    [[nodiscard]] float albedo() const { return 0.5F; }
  };
  using V = gmis::Vec3<float>;
  const V up(0, 0, 1), to_prev = glm::normalize(V(0.3F, 0.2F, -0.7F));
  const auto bsdf_for = [&](const V& from) { return OneSided{glm::dot(from, up) > 0 ? up : -up}; };
  gmis::CheckSettings few;
  few.samples = 20'000;
  few.bins = 100;
  gmis::Philox source(gmis_test::seed(6));
  const gmis::BsdfCheck check = gmis::check_bsdf(bsdf_for, up, to_prev, source, few);
  CHECK(check.passes(1e-6));
  // Stored once, for another side, the same BSDF is no BSDF of this point.
  CHECK_FALSE(gmis::check_bsdf(OneSided{up}, up, to_prev, source, few).reverse_error < 1e-3);
}
