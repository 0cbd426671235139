#include <gmis/mis.hpp>
#include <gmis/mis/diagnostics/tabulated_problem.hpp>
#include <list>
#include <memory>

// An estimate, and with GMIS_FAULT_… one thing wrong with what it is called with.

struct Coin {
  double sample(gmis::UniformSource auto& source) const { return gmis::uniform<double>(source); }
  double pdf(double) const { return 1.0; }
};

#if defined(GMIS_FAULT_no_pdf) || defined(GMIS_FAULT_tuple_without_pdf) || defined(GMIS_FAULT_run_time_scheme) || \
    defined(GMIS_FAULT_run_time_pair) || defined(GMIS_FAULT_groups) || defined(GMIS_FAULT_heuristic)
struct Item {
  double sample(gmis::UniformSource auto& source) const { return gmis::uniform<double>(source); }
};
#elif defined(GMIS_FAULT_no_sample)
struct Item {
  double pdf(double) const { return 1.0; }
};
#elif defined(GMIS_FAULT_sample_not_const)
struct Item {
  double sample(gmis::UniformSource auto& source) { return gmis::uniform<double>(source); }
  double pdf(double) const { return 1.0; }
};
#elif defined(GMIS_FAULT_pdf_not_const)
struct Item {
  double sample(gmis::UniformSource auto& source) const { return gmis::uniform<double>(source); }
  double pdf(double) { return 1.0; }
};
#elif defined(GMIS_FAULT_integral_density)
struct Item {
  double sample(gmis::UniformSource auto& source) const { return gmis::uniform<double>(source); }
  int pdf(double) const { return 1; }
};
#elif defined(GMIS_FAULT_void_sample)
struct Item {
  void sample(gmis::UniformSource auto&) const {}
  double pdf(double) const { return 1.0; }
};
#else
using Item = Coin;
#endif

#if defined(GMIS_FAULT_pointers)
using Set = std::vector<std::unique_ptr<Item>>;
#elif defined(GMIS_FAULT_list)
using Set = std::list<Item>;
#elif defined(GMIS_FAULT_single)
using Set = Item;
#elif defined(GMIS_FAULT_incomplete_set)
struct Set {
  using Value = double;
  using Density = double;
};
#elif defined(GMIS_FAULT_no_set)
struct Set {};
#elif defined(GMIS_FAULT_mixed_tuple)
struct Vector {
  glm::vec3 sample(gmis::UniformSource auto&) const { return {}; }
  float pdf(const glm::vec3&) const { return 1.0F; }
};
using Set = std::tuple<Item, Vector>;
#elif defined(GMIS_FAULT_empty_tuple)
using Set = std::tuple<>;
#elif defined(GMIS_FAULT_tuple_without_pdf)
using Set = std::tuple<Coin, Item>;
#else
using Set = std::vector<Item>;
#endif

#if defined(GMIS_FAULT_other_argument)
double f(const glm::vec3& x) {
  return x.x;
}
#elif defined(GMIS_FAULT_string_value)
const char* f(double) {
  return "1";
}
#else
double f(double x) {
  return x;
}
#endif

#if defined(GMIS_FAULT_const_source)
using Source = const gmis::Philox;
#elif defined(GMIS_FAULT_no_source)
struct Source {};
#else
using Source = gmis::Philox;
#endif

double mean(const Set& set, Source& source) {
#if defined(GMIS_FAULT_run_time_scheme)
  return gmis::estimate(gmis::Scheme::N3, f, set, 10, source).mean;
#elif defined(GMIS_FAULT_run_time_pair)
  return gmis::estimate(gmis::Selection::S1, gmis::Weighting::W3, f, set, 10, source).mean;
#elif defined(GMIS_FAULT_groups)
  return gmis::estimate_partial(f, set, gmis::Groups<>(4, 2), 10, source).mean;
#elif defined(GMIS_FAULT_heuristic)
  return gmis::estimate_weighted(gmis::Power{}, f, set, 10, source).mean;
#elif defined(GMIS_FAULT_many_channels)
  static_cast<void>(source);
  return gmis::TabulatedProblem([](double x) { return glm::dvec3(x); }, set, gmis::gauss_legendre(4)).integral();
#elif defined(GMIS_FAULT_temporary_set)
  static_cast<void>(set);
  static_cast<void>(source);
  const auto of_temporary = gmis::as_proposal_set(Set(2));
  return f(static_cast<double>(of_temporary.size()));
#else
  return gmis::estimate<gmis::Scheme::N3>(f, set, 10, source).mean;
#endif
}
