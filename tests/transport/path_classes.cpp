#include "gmis/transport/state/path_class.hpp"

#include <map>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include "gmis/transport/plan/effect_switches.hpp"
#include "gmis/transport/state/path_filter.hpp"
#include "support/catch.hpp"

// The classes of paths against regular expressions over the events of a path, written from the
// light to the camera: an oracle that knows nothing of subpaths and their states.

namespace {

using gmis::HalfPath;
using gmis::PathClass;
using gmis::PathClassSet;
using gmis::PathEvent;

/// With X for D or G; a name with G stands for the paths of its name with D that have a G.
const std::map<std::string, std::string>& patterns() {
  static const std::map<std::string, std::string> result{{"LE", ""},
                                                         {"LS+E", "S+"},
                                                         {"LDE", "X"},
                                                         {"LS+DE", "S+X"},
                                                         {"LDS+E", "XS+"},
                                                         {"LS+DS+E", "S+XS+"},
                                                         {"LDD+E", "XX+"},
                                                         {"LS+DD+E", "S+XX+"},
                                                         {"LDD+S+E", "XX+S+"},
                                                         {"LS+DD+S+E", "S+XX+S+"},
                                                         {"LDS+DE", "X[XS]*S[XS]*X"},
                                                         {"LS+DS+DE", "S+X[XS]*S[XS]*X"},
                                                         {"LDS+DS+E", "X[XS]*S[XS]*XS+"},
                                                         {"LS+DS+DS+E", "S+X[XS]*S[XS]*XS+"}};
  return result;
}

std::string replaced(std::string text, char from, char to) {
  for (char& c : text)
    if (c == from) c = to;
  return text;
}

/// Every name whose pattern matches.
std::set<std::string> names_of(const std::string& events) {
  static const auto compiled = [] {
    std::vector<std::pair<std::string, std::regex>> result;
    for (const auto& [name, pattern] : patterns()) result.emplace_back(name, std::regex(pattern));
    return result;
  }();
  const bool has_glossy = events.find('G') != std::string::npos;
  const std::string shape = replaced(replaced(events, 'G', 'X'), 'D', 'X');
  std::set<std::string> names;
  for (const auto& [name, pattern] : compiled)
    if (std::regex_match(shape, pattern)) names.insert(has_glossy ? replaced(name, 'D', 'G') : name);
  return names;
}

std::vector<std::string> all_events(std::size_t longest) {
  std::vector<std::string> result{""};
  for (std::size_t begin = 0, length = 0; length < longest; ++length) {
    const std::size_t end = result.size();
    for (std::size_t i = begin; i < end; ++i)
      for (const char event : {'D', 'G', 'S'}) result.push_back(result[i] + event);
    begin = end;
  }
  return result;
}

template <class Iterator>
HalfPath half_of(Iterator begin, Iterator end) {
  HalfPath half;
  for (; begin != end; ++begin)
    half = half.then(*begin == 'D' ? PathEvent::diffuse : *begin == 'G' ? PathEvent::glossy : PathEvent::specular);
  return half;
}

/// The class of the whole, from a light subpath of the first `split` events and a camera subpath of
/// the others.
PathClass class_of_split(const std::string& events, std::size_t split) {
  const auto middle = static_cast<std::ptrdiff_t>(split);
  return class_of(half_of(events.begin(), events.begin() + middle), half_of(events.rbegin(), events.rend() - middle));
}

}  // namespace

TEST_CASE("every path of at most 8 edges has one class, the same by every technique that makes it") {
  std::set<std::string> seen;
  for (const std::string& events : all_events(7)) {
    const auto expected = names_of(events);
    INFO(events);
    REQUIRE(expected.size() == 1);
    seen.insert(*expected.begin());
    for (std::size_t split = 0; split <= events.size(); ++split)
      REQUIRE(std::string(gmis::name_of(class_of_split(events, split))) == *expected.begin());
  }
  CHECK(seen.size() == gmis::path_class_count);
}

TEST_CASE("a class is known by its features, and has the depth of its shortest path") {
  std::map<std::string, std::size_t> shortest;
  for (const std::string& events : all_events(5)) {
    const std::string name = *names_of(events).begin();
    if (!shortest.count(name)) shortest[name] = events.size() + 1;  // shorter ones come first
  }
  for (std::size_t i = 0; i < gmis::path_class_count; ++i) {
    const auto path_class = static_cast<PathClass>(i);
    CAPTURE(std::string(gmis::name_of(path_class)));
    CHECK(gmis::class_with(gmis::features_of(path_class)) == path_class);
    CHECK(gmis::least_depth(path_class) == static_cast<int>(shortest[std::string(gmis::name_of(path_class))]));
  }
  CHECK(gmis::name_of(PathClass::unclassified) == "unclassified");
}

TEST_CASE("what a subpath can become part of is what its continuations are") {
  const auto continuations = all_events(5);  // S D S D S is the longest that any class needs
  for (const std::string& begun : all_events(3)) {
    PathClassSet from_light, from_camera;
    for (const std::string& rest : continuations) {
      from_light.add(class_of_split(begun + rest, begun.size()));
      from_camera.add(class_of_split(rest + begun, rest.size()));
    }
    INFO(begun);
    CHECK(gmis::classes_from_light(half_of(begun.begin(), begun.end())) == from_light);
    CHECK(gmis::classes_from_camera(half_of(begun.rbegin(), begun.rend())) == from_camera);
    for (std::size_t i = 0; i < gmis::path_class_count; ++i) {
      PathClassSet wanted;
      wanted.add(static_cast<PathClass>(i));
      const gmis::PathFilter filter(wanted);
      CHECK(filter.keeps_light(half_of(begun.begin(), begun.end())) == from_light.intersects(wanted));
      CHECK(filter.keeps_camera(half_of(begun.rbegin(), begun.rend())) == from_camera.intersects(wanted));
    }
  }
}

TEST_CASE("sets of classes") {
  PathClassSet set;
  CHECK(set.is_empty());
  set.add(static_cast<PathClass>(3));
  set.add(static_cast<PathClass>(25));
  CHECK(set.size() == 2);
  CHECK(set.contains(static_cast<PathClass>(25)));
  CHECK_FALSE(set.contains(static_cast<PathClass>(24)));
  CHECK(PathClassSet::all().size() == static_cast<int>(gmis::path_class_count));
  CHECK((PathClassSet::all() - set).size() == static_cast<int>(gmis::path_class_count) - 2);
  CHECK_FALSE((PathClassSet::all() - set).intersects(set));
  std::vector<int> visited;
  set.for_each([&](PathClass path_class) { visited.push_back(static_cast<int>(path_class)); });
  CHECK(visited == std::vector<int>{3, 25});
}

TEST_CASE("named effects: four part all paths, and lists of switches mean what they say") {
  // By the events of a path, not by the features of its class.
  const auto is_in = [](const std::string& effect, const std::string& events) {
    const std::size_t scatterings =
        events.size() - static_cast<std::size_t>(std::count(events.begin(), events.end(), 'S'));
    const bool is_lit_specularly = !events.empty() && events.front() == 'S';
    if (effect == "emission") return scatterings == 0;
    if (effect == "direct") return scatterings == 1 && !is_lit_specularly;
    if (effect == "caustics") return scatterings > 0 && is_lit_specularly;
    if (effect == "indirect") return scatterings > 1 && !is_lit_specularly;
    if (effect == "mirrored") return !events.empty() && events.back() == 'S';
    if (effect == "specular") return events.find('S') != std::string::npos;
    REQUIRE(effect == "glossy");
    return events.find('G') != std::string::npos;
  };
  for (const std::string& events : all_events(5)) {
    int parts = 0;
    for (std::size_t i = 0; i < gmis::named_effects.size(); ++i) {
      const gmis::NamedEffect& effect = gmis::named_effects[i];
      INFO(events << ", " << effect.name);
      const bool is_member = effect.classes.contains(class_of_split(events, 0));
      CHECK(is_member == is_in(std::string(effect.name), events));
      if (i < 4) parts += is_member ? 1 : 0;
    }
    CHECK(parts == 1);
  }

  const auto named = [](std::string_view name) {
    for (const gmis::NamedEffect& effect : gmis::named_effects)
      if (effect.name == name) return effect.classes;
    return PathClassSet();
  };
  const PathClassSet all = PathClassSet::all();
  const auto classes = [](std::string_view list) {
    const gmis::SwitchedEffects effects = gmis::switched_effects(list);
    CHECK(effects.unknown.empty());
    return effects.classes;
  };
  CHECK(classes("no-caustics") == all - named("caustics"));
  CHECK(classes("direct-only") == named("direct"));
  CHECK(classes("emission-only,direct-only") == (named("emission") | named("direct")));
  CHECK(classes("no-glossy,direct-only,no-mirrored") == named("direct") - named("glossy") - named("mirrored"));
  CHECK(classes("LS+DE-only").size() == 1);
  CHECK(classes("no-LE").size() == static_cast<int>(gmis::path_class_count) - 1);
  for (const auto& [list, unknown] : {std::pair("", "(nothing)"),
                                      {"no-", "no-"},
                                      {"caustics", "caustics"},
                                      {"no-caustics,", "(nothing)"},
                                      {"no-caustics,no-fog,no-rain", "no-fog"},
                                      {"-only", "-only"}}) {
    CAPTURE(std::string(list));
    CHECK(std::string(gmis::switched_effects(list).unknown) == unknown);
  }
}

// At compile time a shift by more than the width of the number is an error.
static_assert(!PathClassSet::all().contains(PathClass::unclassified));
static_assert([] {
  PathClassSet set;
  set.add(PathClass::unclassified);
  return set.is_empty();
}());

TEST_CASE("Paths that are not classified are in no set of classes") {
  PathClassSet set = PathClassSet::all();
  set.add(PathClass::unclassified);
  CHECK(set == PathClassSet::all());
  CHECK(set.size() == static_cast<int>(gmis::path_class_count));
}
