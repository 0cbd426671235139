#include "gmis/core/concept_diagnostics.hpp"

#include <array>
#include <memory>
#include <optional>

#include "gmis/mis/proposal.hpp"
#include "gmis/scene/surface_model.hpp"

// A type for each concept, and with GMIS_FAULT_… one thing wrong with one of them.

struct Colour {  // a program's own vector class
  float r = 0, g = 0, b = 0;
  Colour() = default;
#ifdef GMIS_FAULT_spectrum_copies
  Colour(const Colour&) = default;
  Colour& operator=(const Colour&) = delete;
#endif
#ifndef GMIS_FAULT_spectrum_from_scalar
  explicit Colour(float all) : r(all), g(all), b(all) {}
#endif
#ifndef GMIS_FAULT_spectrum_sum
  friend Colour operator+(const Colour& x, const Colour&) {
    return x;
  }
#endif
#ifndef GMIS_FAULT_spectrum_addition
  Colour& operator+=(const Colour&) {
    return *this;
  }
#endif
#ifndef GMIS_FAULT_spectrum_product
  friend Colour operator*(const Colour& x, const Colour&) {
    return x;
  }
#endif
#ifndef GMIS_FAULT_spectrum_scaling
  friend Colour operator*(const Colour& x, float) {
    return x;
  }
#endif
};
#ifndef GMIS_FAULT_spectrum_traits
template <>
struct gmis::SpectrumTraits<Colour> {
  using Scalar = float;
  static constexpr int channel_count = 3;
  static float channel(const Colour& c, int i) { return i == 0 ? c.r : i == 1 ? c.g : c.b; }
};
#endif

#ifdef GMIS_FAULT_bsdf_own_vectors
struct Vector {
  float x, y, z;
};
#else
using Vector = glm::vec3;
#endif
using Mode = gmis::TransportMode;
using Point = gmis::SurfacePoint<float>;
using Uv = glm::vec2;

struct Lambert {
#ifdef GMIS_FAULT_bsdf_copies
  Lambert(const Lambert&) = delete;
#endif
#ifndef GMIS_FAULT_bsdf_spectrum
  using Spectrum = Colour;
#endif
#ifdef GMIS_FAULT_bsdf_evaluate_value
  Colour evaluate(const Vector&, const Vector&, Mode) const {
    return {};
  }
#elif defined(GMIS_FAULT_bsdf_other_scalar)
  gmis::BsdfValue<glm::dvec3> evaluate(const Vector&, const Vector&, Mode) const {
    return {};
  }
#elif !defined(GMIS_FAULT_bsdf_evaluate)
  gmis::BsdfValue<Colour> evaluate(const Vector&, const Vector&, Mode) const {
    return {Colour(), {}};
  }
#endif
#ifdef GMIS_FAULT_bsdf_sample_plain
  gmis::ScatterSample<Colour> sample(const Vector&, float, const Uv&, Mode) const {
    return {};
  }
#elif defined(GMIS_FAULT_bsdf_sample_pointer)
  const gmis::ScatterSample<Colour>* sample(const Vector&, float, const Uv&, Mode) const {
    return nullptr;
  }
#elif !defined(GMIS_FAULT_bsdf_sample)
  std::optional<gmis::ScatterSample<Colour>> sample(const Vector&, float, const Uv&, Mode) const {
    return {};
  }
#endif
#ifndef GMIS_FAULT_bsdf_is_purely_delta
  bool is_purely_delta() const {
    return false;
  }
#endif
#ifdef GMIS_FAULT_bsdf_albedo_not_const
  Colour albedo() {
    return {};
  }
#elif !defined(GMIS_FAULT_bsdf_albedo)
  Colour albedo() const {
    return {};
  }
#endif
};

struct Lobes : Lambert {
#ifndef GMIS_FAULT_lobes_max_lobes
  static constexpr int max_lobes = 2;
#endif
#ifndef GMIS_FAULT_lobes_lobe_count
  int lobe_count() const {
    return 1;
  }
#endif
#ifndef GMIS_FAULT_lobes_lobe_weight
  float lobe_weight(int) const {
    return 1;
  }
#endif
#ifdef GMIS_FAULT_lobes_sample_lobe_plain
  glm::vec3 sample_lobe(int, const Vector&, const Uv&, Mode) const {
    return {};
  }
#elif !defined(GMIS_FAULT_lobes_sample_lobe)
  std::optional<glm::vec3> sample_lobe(int, const Vector&, const Uv&, Mode) const {
    return {};
  }
#endif
#ifndef GMIS_FAULT_lobes_lobe_pdfs
  void lobe_pdfs(const Vector&, const Vector&, float*) const {}
#endif
#ifndef GMIS_FAULT_lobes_has_delta_lobes
  bool has_delta_lobes() const {
    return false;
  }
#endif
#ifndef GMIS_FAULT_lobes_lobes_have_full_support
  bool lobes_have_full_support() const {
    return true;
  }
#endif
};

struct Lamp {
#ifndef GMIS_FAULT_light_spectrum
  using Spectrum = Colour;
#endif
#ifndef GMIS_FAULT_light_is_delta
  bool is_delta() const {
    return false;
  }
#endif
#ifndef GMIS_FAULT_light_is_infinite
  bool is_infinite() const {
    return false;
  }
#endif
#ifdef GMIS_FAULT_light_sample_next_event_plain
  gmis::NextEventSample<Colour> sample_next_event(const Point&, const Uv&) const {
    return {};
  }
#elif !defined(GMIS_FAULT_light_sample_next_event)
  std::optional<gmis::NextEventSample<Colour>> sample_next_event(const Point&, const Uv&) const {
    return {};
  }
#endif
#ifdef GMIS_FAULT_light_sample_emission_plain
  gmis::EmissionSample<Colour> sample_emission(const Uv&, const Uv&) const {
    return {};
  }
#elif !defined(GMIS_FAULT_light_sample_emission)
  std::optional<gmis::EmissionSample<Colour>> sample_emission(const Uv&, const Uv&) const {
    return {};
  }
#endif
#ifdef GMIS_FAULT_light_emitted_radiance
  Colour emitted(const Point&, const glm::vec3&) const {
    return {};
  }
#elif !defined(GMIS_FAULT_light_emitted)
  gmis::Emitted<Colour> emitted(const Point&, const glm::vec3&) const {
    return {Colour(), {}};
  }
#endif
#ifdef GMIS_FAULT_light_next_event_density_double
  double next_event_density(const Point&, const glm::vec3&, const Point&) const {
    return 1;
  }
#elif !defined(GMIS_FAULT_light_next_event_density)
  float next_event_density(const Point&, const glm::vec3&, const Point&) const {
    return 1;
  }
#endif
};

struct Pinhole {
#ifndef GMIS_FAULT_camera_spectrum
  using Spectrum = Colour;
#endif
#ifndef GMIS_FAULT_camera_resolution
  glm::ivec2 resolution() const {
    return {};
  }
#endif
#ifdef GMIS_FAULT_camera_sample_ray_plain
  gmis::CameraSample<Colour> sample_ray(glm::ivec2, const Uv&, const Uv&) const {
    return {};
  }
#elif !defined(GMIS_FAULT_camera_sample_ray)
  std::optional<gmis::CameraSample<Colour>> sample_ray(glm::ivec2, const Uv&, const Uv&) const {
    return {};
  }
#endif
#ifdef GMIS_FAULT_camera_project_pixel
  std::optional<glm::ivec2> project(const glm::vec3&, const Uv&) const {
    return {};
  }
#elif !defined(GMIS_FAULT_camera_project)
  std::optional<gmis::CameraProjection<Colour>> project(const glm::vec3&, const Uv&) const {
    return {};
  }
#endif
#ifndef GMIS_FAULT_camera_has_parallel_rays
  bool has_parallel_rays() const {
    return false;
  }
#endif
};

#ifdef GMIS_FAULT_scene_one_spectrum
struct Grey : Pinhole {
  using Spectrum = float;
  std::optional<gmis::CameraSample<float>> sample_ray(glm::ivec2, const Uv&, const Uv&) const { return {}; }
  std::optional<gmis::CameraProjection<float>> project(const glm::vec3&, const Uv&) const { return {}; }
};
#else
using Grey = Pinhole;
#endif

struct World {
#ifndef GMIS_FAULT_scene_spectrum
  using Spectrum = Colour;
#endif
#ifndef GMIS_FAULT_scene_bsdf
  using Bsdf = Lambert;
#endif
#ifndef GMIS_FAULT_scene_light
  using Light = Lamp;
#endif
#ifndef GMIS_FAULT_scene_camera_type
  using Camera = Grey;
#endif
#ifdef GMIS_FAULT_scene_intersect_pointer
  const gmis::Hit<float, Lambert, Lamp>* intersect(const gmis::Ray<float>&) const {
    return nullptr;
  }
#elif defined(GMIS_FAULT_scene_intersect_double)
  std::optional<gmis::Hit<double, Lambert, Lamp>> intersect(const gmis::Ray<float>&) const {
    return {};
  }
#elif !defined(GMIS_FAULT_scene_intersect)
  std::optional<gmis::Hit<float, Lambert, Lamp>> intersect(const gmis::Ray<float>&) const {
    return {};
  }
#endif
#ifdef GMIS_FAULT_scene_visible_int
  int visible(const gmis::Ray<float>&) const {
    return 1;
  }
#elif !defined(GMIS_FAULT_scene_visible)
  bool visible(const gmis::Ray<float>&) const {
    return true;
  }
#endif
#ifdef GMIS_FAULT_scene_sample_light_pointer
  const Lamp* sample_light(float) const {
    return nullptr;
  }
#elif !defined(GMIS_FAULT_scene_sample_light)
  gmis::LightChoice<float, Lamp> sample_light(float) const {
    return {};
  }
#endif
#ifndef GMIS_FAULT_scene_selection_probability
  float selection_probability(const Lamp&) const {
    return 1;
  }
#endif
#ifdef GMIS_FAULT_scene_infinite_lights_objects
  const std::array<Lamp, 1>& infinite_lights() const {
    return lamps;
  }
  std::array<Lamp, 1> lamps;
#elif !defined(GMIS_FAULT_scene_infinite_lights)
  std::array<const Lamp*, 1> infinite_lights() const {
    return {};
  }
#endif
#ifndef GMIS_FAULT_scene_camera
  const Grey& camera() const {
    return pinhole;
  }
#endif
  Grey pinhole;
};

struct Pool {
#ifdef GMIS_FAULT_executor_pointers
  void parallel_for(std::size_t, void (*)(std::size_t)) {}  // the engine's lambdas have captures
#elif !defined(GMIS_FAULT_executor_parallel_for)
  void parallel_for(std::size_t, auto&&) {}
#endif
};

struct Dice {
  using result_type = unsigned;
#ifndef GMIS_FAULT_source_min
  static constexpr result_type min() {
    return 1;
  }
#endif
#ifdef GMIS_FAULT_source_max_below_min
  static constexpr result_type max() {
    return 0;
  }
#elif !defined(GMIS_FAULT_source_max)
  static constexpr result_type max() {
    return 6;
  }
#endif
#ifdef GMIS_FAULT_source_signed
  int operator()() {
    return 4;
  }
#elif !defined(GMIS_FAULT_source_call)
  result_type operator()() {
    return 4;
  }
#endif
};

struct Coin {
#ifdef GMIS_FAULT_proposal_other_value
  int sample(gmis::UniformSource auto&) const {
    return 1;
  }
#elif !defined(GMIS_FAULT_proposal_sample)
  float sample(gmis::UniformSource auto&) const {
    return 0.5F;
  }
#endif
#ifdef GMIS_FAULT_proposal_integral_pdf
  int pdf(float) const {
    return 1;
  }
#elif !defined(GMIS_FAULT_proposal_pdf)
  float pdf(float) const {
    return 1;
  }
#endif
};

struct Nothing {
#ifdef GMIS_FAULT_model_spectrum
  using Spectrum = float;
#else
  using Spectrum = glm::vec3;
#endif
#ifdef GMIS_FAULT_model_material
  struct Stuff {};
  using Material = std::unique_ptr<Stuff>;
#else
  struct Material {};
#endif
#ifndef GMIS_FAULT_model_constructor
  Nothing(const Material&, const glm::vec3&, const glm::vec3&) {}
#endif
  gmis::BsdfValue<Spectrum> evaluate(const glm::vec3&, const glm::vec3&, Mode) const {
    return {};
  }
  std::optional<gmis::ScatterSample<Spectrum>> sample(const glm::vec3&, float, const Uv&, Mode) const {
    return {};
  }
#ifndef GMIS_FAULT_model_bsdf
  bool is_purely_delta() const {
    return true;
  }
#endif
  Spectrum albedo() const {
    return Spectrum(0);
  }
};
#ifndef GMIS_FAULT_model_add_effects_of
inline void add_effects_of(const Nothing::Material&, gmis::Effects&) {}
#endif

// GMIS_ASK asks for one of them, 0 for all.
#ifndef GMIS_ASK
#define GMIS_ASK 0
#endif
#if GMIS_ASK == 0 || GMIS_ASK == 1
static_assert(gmis::IsBsdf<Lambert>());
#endif
#if GMIS_ASK == 0 || GMIS_ASK == 2
static_assert(gmis::IsBsdfWithLobes<Lobes>());
#endif
#if GMIS_ASK == 0 || GMIS_ASK == 3
static_assert(gmis::IsLight<Lamp>());
#endif
#if GMIS_ASK == 0 || GMIS_ASK == 4
static_assert(gmis::IsCamera<Pinhole>());
#endif
#if GMIS_ASK == 0 || GMIS_ASK == 5
static_assert(gmis::IsScene<World>());
#endif
#if GMIS_ASK == 0 || GMIS_ASK == 6
static_assert(gmis::IsExecutor<Pool>());
#endif
#if GMIS_ASK == 0 || GMIS_ASK == 7
static_assert(gmis::IsUniformSource<Dice>());
#endif
#if GMIS_ASK == 0 || GMIS_ASK == 8
static_assert(gmis::IsProposal<Coin, float>());
#endif
#if GMIS_ASK == 0 || GMIS_ASK == 9
static_assert(gmis::scene::IsSurfaceModel<Nothing, float>());
#endif
